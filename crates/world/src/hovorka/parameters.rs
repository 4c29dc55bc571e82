//! Parameters of the Hovorka body and how they differ between people.

use ode_sim::OdeParameters;
use physiology::Kilograms;
use rand::Rng;

use crate::stream::standard_normal;

/// The body of one person: model parameters and weight.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct HovorkaParameters {
    /// Parameters of the ODE model.
    pub model: OdeParameters,
    /// Body weight.
    pub weight: Kilograms,
}

impl HovorkaParameters {
    /// The nominal adult with type 1 diabetes.
    #[must_use]
    pub fn nominal() -> Self {
        Self { model: OdeParameters::nominal(), weight: Kilograms(76.3) }
    }

    /// One draw around the nominal body, accepted or not.
    ///
    /// Log-normal factors with these standard deviations: 0.25 shared by the three insulin
    /// sensitivities and 0.15 for each alone; EGP0 and F01 0.10; t_max,I 0.15; t_max,G 0.18;
    /// k_e and V_I 0.08; V_G 0.05; A_G normal 0.80 (SD 0.05). Resalat et al. 2019 vary the
    /// sensitivities alone (their relative spreads are 0.28 to 0.39); the others follow the
    /// between-person spreads of Hovorka et al. (Am J Physiol Endocrinol Metab 2002;282:E992),
    /// rounded. Weight normal 76.3 kg (SD 15.9), 50 to 115 kg.
    pub(super) fn draw(rng: &mut (impl Rng + ?Sized)) -> Self {
        let nominal = OdeParameters::nominal();
        let mut factor = |sd: f64| (sd * standard_normal(rng)).clamp(-2.5 * sd, 2.5 * sd).exp();
        let shared = factor(0.25);
        let model = OdeParameters {
            s_f1: nominal.s_f1 * shared * factor(0.15),
            s_f2: nominal.s_f2 * shared * factor(0.15),
            s_f3: nominal.s_f3 * shared * factor(0.15),
            egp_0: nominal.egp_0 * factor(0.10),
            f_01: nominal.f_01 * factor(0.10),
            t_max_i: nominal.t_max_i * factor(0.15),
            t_max_g: nominal.t_max_g * factor(0.18),
            k_e: nominal.k_e * factor(0.08),
            v_i: nominal.v_i * factor(0.08),
            v_g: nominal.v_g * factor(0.05),
            ..nominal
        };
        let a_g = (0.80 + 0.05 * standard_normal(rng)).clamp(0.65, 0.95);
        let weight = (76.3 + 15.9 * standard_normal(rng)).clamp(50.0, 115.0);
        Self { model: OdeParameters { a_g, ..model }, weight: Kilograms(weight) }
    }

    /// Each parameter of the model with its name.
    #[must_use]
    pub fn named(&self) -> Vec<(&'static str, f64)> {
        self.model.named().to_vec()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::body::BodyModel;
    use crate::stream::{Concept, stream};
    use physiology::MgPerDl;

    #[test]
    fn bodies_differ_and_none_is_nominal() {
        let bodies: Vec<HovorkaParameters> = (0..20)
            .map(|person| {
                HovorkaParameters::sample(person, &mut stream(5, person, Concept::Body))
                    .expect("one in two draws is accepted")
            })
            .collect();
        let nominal = OdeParameters::nominal();
        for body in &bodies {
            let basal = body.at_rest(MgPerDl(115.0)).expect("accepted before").1.0;
            assert!((0.45..=1.35).contains(&basal), "{basal}");
            let untouched =
                body.model.named().iter().zip(nominal.named()).filter(|(a, b)| *a == b).count();
            assert_eq!(untouched, 4); // k_12, k_a1, k_a2 and k_a3 are shared by everybody
        }
        let mean = bodies.iter().map(|b| b.weight.0).sum::<f64>() / 20.0;
        // Four standard errors of the mean of twenty.
        assert!((mean - 76.3).abs() < 4.0 * 15.9 / 20.0_f64.sqrt(), "{mean}");
    }
}
