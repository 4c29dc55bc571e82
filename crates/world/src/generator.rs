//! Which kind of body a world is made of.

use serde::Serialize;

named::named_in_json! {
    /// A generator of bodies. No two share an equation of glucose, insulin or the gut; what hard
    /// exercise releases is of one form in `padova` and `saturating`.
    #[derive(Serialize)]
    Generator {
        /// The ODE of Resalat et al. 2019 (after Hovorka et al. 2004) with a person's own
        /// parameters, at one minute: [`hovorka`](crate::hovorka).
        Hovorka: "hovorka",
        /// The structure of the UVA/Padova simulator (Dalla Man et al. 2007 and 2014):
        /// [`padova`](crate::padova).
        Padova: "padova",
        /// A minimal model with remote insulin, a stomach with a clock and its own depot:
        /// [`minimal`](crate::minimal).
        Minimal: "minimal",
        /// Saturating uptake, glucagon and two channels of insulin:
        /// [`saturating`](crate::saturating).
        Saturating: "saturating",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generators_are_read_as_they_are_written() {
        for generator in Generator::ALL {
            assert_eq!(Generator::from_name(generator.name()), Some(generator));
        }
        assert_eq!(Generator::from_name("bergman"), None);
    }
}
