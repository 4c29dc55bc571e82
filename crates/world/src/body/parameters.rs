//! Parameters of a kind of body: each stands once, with its nominal value and its spread.

use physiology::Kilograms;
use rand::Rng;

use crate::stream::standard_normal;

/// How a parameter differs between people.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Spread {
    /// Not at all.
    Fixed,
    /// By a log-normal factor with this standard deviation.
    Own(f64),
    /// By a factor that several parameters share.
    Shared(usize),
    /// By such a factor and by one of its own.
    SharedAndOwn(usize, f64),
    /// The same, as divisors.
    Inverse(usize, f64),
    /// Normal, with this mean and standard deviation.
    Normal(f64, f64),
}

/// One draw of the parameters and of the weight. Normal deviates end at 2.5 standard deviations in
/// factors and at 2 otherwise. `shared` has the standard deviations of what parameters share.
pub(crate) fn draw<const N: usize>(
    nominal: [f64; N],
    spreads: [Spread; N],
    shared: &[f64],
    rng: &mut (impl Rng + ?Sized),
) -> ([f64; N], Kilograms) {
    let mut factor = |sd: f64| (sd * standard_normal(rng)).clamp(-2.5 * sd, 2.5 * sd).exp();
    let shared: Vec<f64> = shared.iter().map(|sd| factor(*sd)).collect();
    let mut drawn = nominal;
    for (value, spread) in drawn.iter_mut().zip(spreads) {
        match spread {
            Spread::Own(sd) => *value *= factor(sd),
            Spread::Shared(which) => *value *= shared[which],
            Spread::SharedAndOwn(which, sd) => *value = *value * shared[which] * factor(sd),
            Spread::Inverse(which, sd) => *value /= shared[which] * factor(sd),
            Spread::Fixed | Spread::Normal(..) => {}
        }
    }
    let mut normal =
        |mean: f64, sd: f64| mean + (sd * standard_normal(rng)).clamp(-2.0 * sd, 2.0 * sd);
    for (value, spread) in drawn.iter_mut().zip(spreads) {
        if let Spread::Normal(mean, sd) = spread {
            *value = normal(mean, sd);
        }
    }
    (drawn, Kilograms(normal(76.3, 15.9).clamp(50.0, 115.0)))
}

/// Declares the parameters of a kind of body, each with its nominal value and its spread, and its
/// weight: normal with mean 76.3 kg (SD 15.9), 50 to 115 kg. `shared` are the standard deviations of
/// the factors that parameters share, in the order in which they are drawn.
macro_rules! parameters {
    (
        $(#[$about:meta])*
        $name:ident, shared $shared:expr;
        $($(#[$entry_about:meta])* $entry:ident: $nominal:expr, $spread:expr;)+
    ) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub struct $name {
            $($(#[$entry_about])* pub $entry: f64,)+
            /// Body weight.
            pub weight: physiology::Kilograms,
        }

        impl $name {
            /// The nominal adult with type 1 diabetes, of 76.3 kg.
            #[must_use]
            pub fn nominal() -> Self {
                Self { $($entry: $nominal,)+ weight: physiology::Kilograms(76.3) }
            }

            /// Each parameter with its name, in the order of the fields.
            #[must_use]
            pub fn named(&self) -> Vec<(&'static str, f64)> {
                vec![$((stringify!($entry), self.$entry)),+]
            }

            /// One draw around the nominal body, accepted or not.
            pub(super) fn draw(rng: &mut (impl rand::Rng + ?Sized)) -> Self {
                let (nominal, spreads) = ([$($nominal),+], [$($spread),+]);
                let ([$($entry),+], weight) = $crate::body::draw(nominal, spreads, &$shared, rng);
                Self { $($entry,)+ weight }
            }
        }
    };
}

pub(crate) use parameters;
