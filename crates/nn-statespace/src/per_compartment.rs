//! One value for each of the ten compartments, reached by name.

use std::ops::{Index, IndexMut};

use physiology::Compartment;

/// One value of type `T` for each compartment, indexed by [`Compartment`].
///
/// ```
/// use nn_statespace::PerCompartment;
/// use physiology::Compartment;
///
/// let mut width = PerCompartment::from_fn(|_| 16_usize);
/// width[Compartment::Q1] = 32;
/// assert_eq!(width.values().sum::<usize>(), 9 * 16 + 32);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct PerCompartment<T>([T; 10]);

impl<T> PerCompartment<T> {
    /// The values that `value` gives for each compartment, asked in the order of
    /// [`Compartment::ALL`].
    pub fn from_fn(value: impl FnMut(Compartment) -> T) -> Self {
        Self(Compartment::ALL.map(value))
    }

    /// The values that `value` gives for each compartment, or its first error.
    ///
    /// # Errors
    /// The first error of `value`.
    pub fn try_from_fn<E>(value: impl FnMut(Compartment) -> Result<T, E>) -> Result<Self, E> {
        let values: Vec<T> = Compartment::ALL.into_iter().map(value).collect::<Result<_, E>>()?;
        Ok(Self(values.try_into().unwrap_or_else(|_| unreachable!("one for each compartment"))))
    }

    /// The values in the order of [`Compartment::ALL`].
    pub fn values(&self) -> impl Iterator<Item = &T> {
        self.0.iter()
    }

    /// The compartments with their values, in the order of [`Compartment::ALL`].
    pub fn iter(&self) -> impl Iterator<Item = (Compartment, &T)> {
        Compartment::ALL.into_iter().zip(&self.0)
    }
}

impl<T> Index<Compartment> for PerCompartment<T> {
    type Output = T;
    fn index(&self, compartment: Compartment) -> &T {
        &self.0[compartment as usize]
    }
}

impl<T> IndexMut<Compartment> for PerCompartment<T> {
    fn index_mut(&mut self, compartment: Compartment) -> &mut T {
        &mut self.0[compartment as usize]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_compartment_keeps_its_own_value() {
        let names = PerCompartment::from_fn(Compartment::name);
        for compartment in Compartment::ALL {
            assert_eq!(names[compartment], compartment.name());
        }
    }

    #[test]
    fn the_first_error_is_returned() {
        let result = PerCompartment::<u8>::try_from_fn(|c| match c {
            Compartment::I => Err("I"),
            Compartment::X1 => Err("X1"),
            _ => Ok(0),
        });
        assert_eq!(result, Err("I"));
    }
}
