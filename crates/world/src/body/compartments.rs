//! Compartments of a kind of body: each stands once, with its unit and what reports a fault in it.

use physiology::{Compartment, NonFinite};

/// Compartments of a body, and their rates of change.
pub trait Compartments: Copy {
    /// The compartments, each with the reporting compartment for a fault in it.
    fn entries(&self) -> impl Iterator<Item = (Compartment, f64)>;

    /// `self + h * slope`, entry by entry.
    #[must_use]
    fn plus(&self, h: f64, slope: &Self) -> Self;

    /// The same compartments, if all are finite.
    ///
    /// # Errors
    /// The first that is not.
    fn finite(self) -> Result<Self, NonFinite> {
        match self.entries().find(|(_, value)| !value.is_finite()) {
            Some((compartment, _)) => Err(NonFinite { compartment }),
            None => Ok(self),
        }
    }

    /// One step of the classical Runge-Kutta method.
    #[must_use]
    fn runge_kutta_4(&self, h: f64, slope: impl Fn(&Self) -> Self) -> Self {
        let k1 = slope(self);
        let k2 = slope(&self.plus(0.5 * h, &k1));
        let k3 = slope(&self.plus(0.5 * h, &k2));
        let k4 = slope(&self.plus(h, &k3));
        self.plus(h / 6.0, &k1).plus(h / 3.0, &k2).plus(h / 3.0, &k3).plus(h / 6.0, &k4)
    }
}

/// Declares the compartments of a kind of body: `name: reporting compartment`.
macro_rules! compartments {
    (
        $(#[$about:meta])*
        $name:ident { $($(#[$entry_about:meta])* $entry:ident: $report:ident,)+ }
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Default)]
        pub struct $name {
            $($(#[$entry_about])* pub $entry: f64,)+
        }

        impl $crate::body::Compartments for $name {
            fn entries(&self) -> impl Iterator<Item = (physiology::Compartment, f64)> {
                [$((physiology::Compartment::$report, self.$entry)),+].into_iter()
            }

            fn plus(&self, h: f64, slope: &Self) -> Self {
                Self { $($entry: self.$entry + h * slope.$entry,)+ }
            }
        }
    };
}

pub(crate) use compartments;
