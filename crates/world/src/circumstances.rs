//! The parts of a person's days that are fixed before the body is simulated.

use rand_chacha::ChaCha8Rng;

use crate::behaviour::Life;
use crate::calendar::Calendar;
use crate::devices::WornSensors;
use crate::effects::{Amplitudes, Happenings, sensing};
use crate::everyday::EverydayCourse;
use crate::logging::Logging;
use crate::stream::{Concept, stream};
use crate::virtual_person::VirtualPerson;
use crate::wear::SensorWear;

impl VirtualPerson {
    /// What the person does over the days of a calendar.
    pub(crate) fn life(&self, calendar: Calendar) -> Life {
        Life::sample_with(&self.habits, &self.everyday.hours, calendar, self.seed, self.index)
    }

    /// The chance events of a life.
    pub(crate) fn happenings(&self, life: &Life) -> Happenings {
        let spreads = &self.everyday.spreads;
        let mut happenings = Happenings::sample_with(life, spreads, self.seed, self.index);
        self.body.vary(&mut happenings, &life.calendar, spreads, self.seed, self.index);
        happenings.everyday = EverydayCourse::sample(&self.everyday, life, self.seed, self.index);
        happenings
    }

    /// The sensors worn through a life in which effects act with `amplitudes`.
    pub(crate) fn sensors(
        &self,
        life: &Life,
        happenings: &Happenings,
        amplitudes: &Amplitudes,
    ) -> WornSensors {
        let (wear, rng) = self.wear(life);
        let sensing = sensing(life, &wear, happenings, &self.shapes, amplitudes);
        let own = stream(self.seed, self.index, Concept::SensorKind);
        WornSensors::new(self.everyday.sensor, wear, sensing, rng, own)
    }

    /// When sensors are worn through a life, and the stream for their errors.
    pub(crate) fn wear(&self, life: &Life) -> (SensorWear, ChaCha8Rng) {
        let mut rng = stream(self.seed, self.index, Concept::Sensor);
        (SensorWear::sample(&life.calendar, &self.everyday.sensor, &mut rng), rng)
    }

    /// How the person keeps the log while effects act with `amplitudes`.
    pub(crate) fn logging(&self, amplitudes: &Amplitudes) -> Logging {
        Logging::new(self.background, self.everyday.log, &self.shapes, amplitudes)
    }
}
