//! Dawn phenomenon: endogenous production rises before and after waking.

use super::prelude::*;

/// Rise of production at the peak at amplitude 1, as a share.
const RISE: f64 = 0.22;
/// Hours of the peak that are tried: the bump spans about 03 to 08 h.
const PEAKS: [f64; 3] = [5.0, 6.0, 7.0];
/// Half width of the bump, h.
const HALF_WIDTH: f64 = 3.0;

/// See the module.
#[derive(Debug, Clone, Copy)]
pub(super) struct Dawn;

impl Effect for Dawn {
    fn card(&self) -> Card {
        Card {
            id: EffectId::DAWN,
            port: Port::Egp,
            summary: "endogenous glucose production rises in the early morning",
            size_at_one: "production 22 % higher at the peak, a bump of six hours",
            source: "mean 12 % (SD 7) over the night's end, 20 to 25 % at the peak: Bolli & Gerich, \
                     N Engl J Med 1984;310:746; Porcellati et al., Diabetes Care 2013;36:3860",
            signature: "glucose under-predicted from about 04 to 09 h on every day",
            channels: &[Channel::Clock],
            confusable_with: &[EffectId::CIRCADIAN_SENSITIVITY],
            relations: Relations { is_itself: &[Allowance::Clock], ..Relations::USUAL },
            prior: Prior { median: 1.0, log_sd: 0.5, largest: 4.0 },
        }
    }

    fn form(&self, _: &Course) -> Option<Form> {
        Some(Form::Driven)
    }

    fn variants(&self) -> usize {
        PEAKS.len()
    }

    fn modulate(&self, variant: usize, amplitude: f64, course: &Course, into: &mut [Modulation]) {
        let peak = PEAKS[variant % PEAKS.len()];
        let factor = |hour: f64| {
            let distance = (hour - peak) / HALF_WIDTH;
            let bump = 0.5 * (1.0 + (std::f64::consts::PI * distance).cos());
            if distance.abs() < 1.0 { 1.0 + amplitude * RISE * bump } else { 1.0 }
        };
        for (factor, modulation) in course.by_hour(factor).zip(into) {
            modulation[Field::Production] *= factor;
        }
    }
}
