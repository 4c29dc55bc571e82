//! The derivative of the filter's model: a matrix of which only what can differ from zero is stored and carried.

use std::ops::{Add, Mul};

use physiology::STEP;

use crate::filter::state::{FLUX, INTERSTITIAL, SENSOR, SENSOR_BEFORE, STATES};

/// A 14 x 14 matrix d(state after)/d(state before) with the zeros of the model's structure, which are not stored. It is
/// in double precision, but in single precision where directions are carried along.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Transition<T = f64>([T; ENTRIES]);

/// Entries that may differ from zero.
const ENTRIES: usize = 35;
/// Indices of the first entries of Q1, Q2, the gut, the flux, interstitial glucose and the sensor error.
const FIRST_OF_Q1: usize = 11;
const FIRST_OF_Q2: usize = 17;
const FIRST_OF_GUT: usize = 21;
const FIRST_OF_FLUX: usize = 24;
const FIRST_OF_INTERSTITIAL: usize = 25;
const FIRST_OF_SENSOR: usize = 32;

impl Default for Transition {
    fn default() -> Self {
        Self([0.0; ENTRIES])
    }
}

impl Transition {
    /// That of a body with the flux, the lag and the sensor around it.
    ///
    /// The decays are the shares of the flux, and of the distance between interstitial and plasma glucose, that are left
    /// after one step. `share` is what interstitial glucose gains per mmol/kg of Q1 at both ends of the step, halved,
    /// mg/dL. `now` and `before` say how much of the sensor error of this step and of the one before is in that of the
    /// next.
    #[inline(always)]
    pub(crate) fn of(
        slopes: &BodySlopes,
        flux_decay: f64,
        lag_decay: f64,
        share: f64,
        [now, before]: [f64; 2],
    ) -> Self {
        let BodySlopes { insulin, glucose, distant, gut } = *slopes;
        // Interstitial glucose follows the mean of Q1 before and after.
        let [x1, x3, q1, q2, c2, flux] = glucose.map(|value| share * value);
        let interstitial = [x1, x3, q1 + share, q2, c2, flux, lag_decay];
        let mut entries = [0.0; ENTRIES];
        entries[..FIRST_OF_Q1].copy_from_slice(&insulin);
        entries[FIRST_OF_Q1..FIRST_OF_Q2].copy_from_slice(&glucose);
        entries[FIRST_OF_Q2..FIRST_OF_GUT].copy_from_slice(&distant);
        entries[FIRST_OF_GUT..FIRST_OF_FLUX].copy_from_slice(&gut);
        entries[FIRST_OF_FLUX] = flux_decay;
        entries[FIRST_OF_INTERSTITIAL..FIRST_OF_SENSOR].copy_from_slice(&interstitial);
        entries[FIRST_OF_SENSOR..].copy_from_slice(&[now, before, 1.0]);
        Self(entries)
    }

    /// The columns of each row that may differ from zero under forward Euler, in the order S1 S2 I X1
    /// X2 X3 Q1 Q2 C1 C2, flux, interstitial, sensor, sensor before.
    pub const NONZERO: [&'static [usize]; STATES] = [
        &[0],
        &[0, 1],
        &[1, 2],
        &[2, 3],
        &[2, 4],
        &[2, 5],
        &[3, 5, 6, 7, 9, FLUX],
        &[3, 4, 6, 7],
        &[8],
        &[8, 9],
        &[FLUX],
        &[3, 5, 6, 7, 9, FLUX, INTERSTITIAL],
        &[SENSOR, SENSOR_BEFORE],
        &[SENSOR],
    ];

    /// Index of an entry in what is stored, row by row.
    fn index(row: usize, column: usize) -> Option<usize> {
        let before: usize = Self::NONZERO[..row].iter().map(|columns| columns.len()).sum();
        Self::NONZERO[row].iter().position(|c| *c == column).map(|index| before + index)
    }

    /// The effect on state `row` of state `column`.
    #[must_use]
    pub fn get(&self, row: usize, column: usize) -> f64 {
        Self::index(row, column).map_or(0.0, |index| self.0[index])
    }

    /// Sets one entry; it must be one of [`Self::NONZERO`] to have an effect.
    pub fn set(&mut self, row: usize, column: usize, value: f64) {
        if let Some(index) = Self::index(row, column) {
            self.0[index] = value;
        }
    }

    /// Replaces what changes from step to step where nothing modulates them: the derivative of Q1 by X1, X3 and
    /// Q1, which interstitial glucose shares in, and that of Q2 by X1, X2, Q1 and Q2.
    #[inline(always)]
    pub(crate) fn vary(&mut self, glucose: [f64; 3], distant: [f64; 4], share: f64) {
        let [by_x1, by_x3, by_q1] = glucose;
        self.0[FIRST_OF_Q1..FIRST_OF_Q1 + 3].copy_from_slice(&glucose);
        self.0[FIRST_OF_Q2..FIRST_OF_GUT].copy_from_slice(&distant);
        self.0[FIRST_OF_INTERSTITIAL] = share * by_x1;
        self.0[FIRST_OF_INTERSTITIAL + 1] = share * by_x3;
        self.0[FIRST_OF_INTERSTITIAL + 2] = share * by_q1 + share;
    }

    /// How much of the sensor error of this step and of the one before is in that of the next, and how much of
    /// this step's is kept beside it.
    #[inline(always)]
    pub(crate) fn sensor(&self) -> [f64; 3] {
        let [.., now, before, kept] = self.0;
        [now, before, kept]
    }

    /// The same matrix in single precision.
    #[inline(always)]
    pub(crate) fn narrowed(&self) -> Transition<f32> {
        let mut narrow = [0.0; ENTRIES];
        for (narrow, entry) in narrow.iter_mut().zip(&self.0) {
            *narrow = *entry as f32;
        }
        Transition(narrow)
    }
}

impl Transition<f32> {
    /// Multiplies vectors by the transposed matrix: `x[state][vector]` becomes `A' x`.
    #[inline(always)]
    pub(crate) fn carry_back<const WIDTH: usize>(&self, x: &mut [[f32; WIDTH]; STATES]) {
        let mut back = [[0.0; WIDTH]; STATES];
        let mut entries = self.0.iter();
        for (row, columns) in x.iter().zip(Transition::NONZERO) {
            for (column, entry) in columns.iter().zip(entries.by_ref()) {
                for (sum, value) in back[*column].iter_mut().zip(row) {
                    *sum += entry * value;
                }
            }
        }
        *x = back;
    }
}

/// Products with vectors that lie side by side. They are inlined always, so that they are compiled for the instructions
/// of whoever calls them.
impl<T: Copy + Add<Output = T> + Mul<Output = T>> Transition<T> {
    /// Multiplies vectors by the matrix: `x[state][vector]` becomes `A x`.
    #[inline(always)]
    pub(crate) fn carry<const WIDTH: usize>(&self, x: &mut [[T; WIDTH]; STATES]) {
        let Some((body, [sensor, before])) = x.split_first_chunk_mut::<SENSOR>() else { return };
        self.carry_body(body);
        let [.., sensor_sensor, sensor_before, before_sensor] = self.0;
        for k in 0..WIDTH {
            let error = sensor_sensor * sensor[k] + sensor_before * before[k];
            before[k] = before_sensor * sensor[k];
            sensor[k] = error;
        }
    }

    /// As [`carry`](Self::carry), all rows but those of the sensor error.
    #[inline(always)]
    pub(crate) fn carry_body<const WIDTH: usize>(&self, x: &mut [[T; WIDTH]; SENSOR]) {
        let [s1_s1, s2_s1, s2_s2, i_s2, i_i, ref rest @ ..] = self.0;
        let [x1_i, x1_x1, x2_i, x2_x2, x3_i, x3_x3, ref rest @ ..] = *rest;
        let [q1_x1, q1_x3, q1_q1, q1_q2, q1_c2, q1_flux, ref rest @ ..] = *rest;
        let [q2_x1, q2_x2, q2_q1, q2_q2, c1_c1, c2_c1, c2_c2, ref rest @ ..] = *rest;
        let [flux_flux, g_x1, g_x3, g_q1, g_q2, g_c2, g_flux, g_g, ..] = *rest;
        let [s1, s2, i, x1, x2, x3, q1, q2, c1, c2, flux, g] = x;
        for k in 0..WIDTH {
            let from_body = q1_x1 * x1[k] + q1_x3 * x3[k] + q1_q1 * q1[k] + q1_q2 * q2[k];
            let glucose = from_body + q1_c2 * c2[k] + q1_flux * flux[k];
            let from_body = g_x1 * x1[k] + g_x3 * x3[k] + g_q1 * q1[k] + g_q2 * q2[k];
            g[k] = from_body + g_c2 * c2[k] + g_flux * flux[k] + g_g * g[k];
            q2[k] = q2_x1 * x1[k] + q2_x2 * x2[k] + q2_q1 * q1[k] + q2_q2 * q2[k];
            q1[k] = glucose;
            x1[k] = x1_i * i[k] + x1_x1 * x1[k];
            x2[k] = x2_i * i[k] + x2_x2 * x2[k];
            x3[k] = x3_i * i[k] + x3_x3 * x3[k];
            i[k] = i_s2 * s2[k] + i_i * i[k];
            s2[k] = s2_s1 * s1[k] + s2_s2 * s2[k];
            s1[k] = s1[k] * s1_s1;
            c2[k] = c2_c1 * c1[k] + c2_c2 * c2[k];
            c1[k] = c1[k] * c1_c1;
            flux[k] = flux[k] * flux_flux;
        }
    }
}

/// The derivative of a body's step by its ten compartments: the entries of a [`Transition`] that are the
/// body's own, and that of Q1 by a flux.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct BodySlopes {
    /// S1 by S1; S2 by S1, S2; I by S2, I; each of X1, X2, X3 by I and itself.
    pub(crate) insulin: [f64; 11],
    /// Q1 by X1, X3, Q1, Q2, C2 and the flux.
    pub(crate) glucose: [f64; 6],
    /// Q2 by X1, X2, Q1, Q2.
    pub(crate) distant: [f64; 4],
    /// C1 by C1; C2 by C1, C2.
    pub(crate) gut: [f64; 3],
}

impl BodySlopes {
    /// Of a forward Euler step, from those of the rates.
    pub(crate) fn of_a_step(mut self) -> Self {
        let Self { insulin, glucose, distant, gut } = &mut self;
        for value in insulin.iter_mut().chain(glucose).chain(distant).chain(gut) {
            *value *= STEP.0;
        }
        for index in [0, 2, 4, 6, 8, 10] {
            self.insulin[index] += 1.0;
        }
        self.glucose[2] += 1.0;
        self.distant[3] += 1.0;
        self.gut[0] += 1.0;
        self.gut[2] += 1.0;
        self
    }
}
