//! What is individual about the form of an effect, apart from its size.

use physiology::Minutes;
use rand::{Rng, RngExt};

use super::circadian_sensitivity::CircadianPattern;
use super::forms::Forms;
use super::renal_threshold::Kidneys;
use crate::stream::standard_normal;

/// The forms that effects take in one person.
///
/// Amplitudes scale an effect. These fields say when it comes, how long it lasts and in which
/// direction it acts. They have no effect in a person in whom the effect is off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shapes {
    /// Hours by which the dawn rise comes later than usual for this waking time.
    pub dawn_shift: f64,
    /// Hours of the day at which insulin acts less.
    pub circadian: CircadianPattern,
    /// Days after which a set begins to age.
    pub set_ageing_onset: f64,
    /// Rise of the production in a low at amplitude 1, as a share. Without glucagon, as in
    /// long-standing type 1 diabetes, adrenaline raises it by 50 to 100 % (Cryer, N Engl J Med
    /// 2013;369:362, of the order of).
    pub counter_regulation: f64,
    /// Its lag.
    pub counter_regulation_time: Minutes,
    /// How the kidneys differ.
    pub renal: Kidneys,
    /// Additional lag of the sensor at amplitude 1: lags of 6 to 12 min are published for the
    /// interstitium alone (Basu et al., Diabetes 2013;62:4083; Facchinetti et al., IEEE Trans
    /// Biomed Eng 2014;61:620), and the filters of a device add theirs.
    pub sensor_lag: Minutes,
    /// Bias of carbohydrate counting relative to the published one.
    pub counting_bias: f64,
    /// The form of each effect, which the people of a world share.
    pub forms: Forms,
}

impl Shapes {
    /// The middle of each form.
    pub const TYPICAL: Self = Self {
        dawn_shift: 0.0,
        circadian: CircadianPattern { trough_hour: 7.5, sharpness: 1.5, depth: 1.0 },
        set_ageing_onset: 1.0,
        counter_regulation: 0.75,
        counter_regulation_time: Minutes(15.0),
        renal: Kidneys { threshold: 1.0, slope: -1.0 },
        sensor_lag: Minutes(7.0),
        counting_bias: 1.0,
        forms: Forms::TYPICAL,
    };

    /// Draws what is individual about one person's forms; the forms are the typical ones.
    ///
    /// Dawn: SD 0.8 h. Action by clock: three in four have their trough in the morning (7:30, SD
    /// 1.5 h), the others in the evening (19:00, SD 2 h). Sets age from day 0.6 to 1.8 on.
    /// Counter-regulation 50 to 100 % with a lag of 10 to 20 min. Four in five kidneys have a
    /// higher threshold and a lower rate than the model, the others the reverse, both by 0.7 to 1.3
    /// times the published change (shares assumed). Sensor lag 4.5 to 9.5 min. Counting bias SD 20
    /// %.
    #[must_use]
    pub fn sample(rng: &mut (impl Rng + ?Sized)) -> Self {
        let mut normal = |sd: f64| (sd * standard_normal(rng)).clamp(-2.0 * sd, 2.0 * sd);
        let (dawn_shift, morning, evening) = (normal(0.8), normal(1.5), normal(2.0));
        let counting_bias = 1.0 + normal(0.2);
        let in_morning = rng.random_bool(0.75);
        let wasteful = rng.random_bool(0.2);
        let direction = if wasteful { -1.0 } else { 1.0 };
        Self {
            dawn_shift,
            circadian: CircadianPattern {
                trough_hour: if in_morning { 7.5 + morning } else { 19.0 + evening },
                sharpness: rng.random_range(0.8..2.5),
                depth: rng.random_range(0.75..1.25),
            },
            set_ageing_onset: rng.random_range(0.6..1.8),
            counter_regulation: rng.random_range(0.5..1.0),
            counter_regulation_time: Minutes(rng.random_range(10.0..20.0)),
            renal: Kidneys {
                threshold: direction * rng.random_range(0.7..1.3),
                slope: -direction * rng.random_range(0.7..1.3),
            },
            sensor_lag: Minutes(rng.random_range(4.5..9.5)),
            counting_bias,
            forms: Forms::TYPICAL,
        }
    }
}
