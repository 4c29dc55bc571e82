//! The label of a world: what `world` made, in the words in which `blind` scores.

pub(crate) mod another_hand;

use anyhow::{Context as _, Result};
use contract::blind_check::{Kind, Label, TrueEffect};
use world::blind::{LivedWorld, PlannedWorld, TrueWhere};

/// Decimals of the truth of "where": a thousandth of a mg/dL is far below what any run tells.
const DECIMALS: f64 = 1000.0;

/// The label of a world under the name `id`.
///
/// # Errors
/// If a body fails in the runs that tell where the effects act.
pub(crate) fn label(id: &str, lived: &LivedWorld) -> Result<Label> {
    let world = &lived.world;
    let planned = &world.planned;
    let effects = world
        .effects
        .iter()
        .map(|found| TrueEffect {
            effect: found.effect.name().to_owned(),
            port: (!found.effect.in_library()).then(|| found.effect.port().name().to_owned()),
            in_library: found.effect.in_library(),
            amplitude: found.amplitude,
            target_mg_dl: found.target,
            achieved_mg_dl: found.achieved,
            at_limit: found.at_limit,
            form: found.form.map(str::to_owned),
        })
        .collect();
    let gap = lived.true_where().with_context(|| format!("where in world {id}"))?;
    Ok(Label {
        id: id.to_owned(),
        kind: kind(planned),
        effects,
        generator: planned.generator.name().to_owned(),
        regime: planned.regime.name().to_owned(),
        people: planned.people,
        days: planned.days,
        nuisances: planned.nuisances.words(),
        seed: planned.seed,
        gap: gap.as_ref().map(true_where),
    })
}

/// The truth of "where" in the words of a label, rounded.
fn true_where(truth: &TrueWhere) -> contract::blind_check::TrueWhere {
    let rounded = |value: f64| (DECIMALS * value).round() / DECIMALS;
    let cells = truth.gap.cells.iter().map(|cell| contract::blind_check::TrueCell {
        factor: cell.factor.name().to_owned(),
        level: cell.level.clone(),
        share: rounded(cell.share),
        mean_mg_dl: cell.mean.map(|mean| mean.map(rounded)),
    });
    let ports = truth.courses.iter().map(|course| contract::blind_check::PortCourse {
        effect: course.effect.name().to_owned(),
        port: course.port.name().to_owned(),
        unit: course.unit.name().to_owned(),
        by_hour: course.by_hour.iter().map(|value| value.map(rounded)).collect(),
    });
    contract::blind_check::TrueWhere {
        mean_mg_dl: truth.gap.mean.map(rounded),
        mean_absolute_mg_dl: truth.gap.mean_absolute.map(rounded),
        cells: cells.collect(),
        ports: ports.collect(),
    }
}

fn kind(planned: &PlannedWorld) -> Kind {
    match planned.effects.as_slice() {
        [] => Kind::Null,
        [(effect, _)] if !effect.in_library() => Kind::Outside,
        [_] => Kind::Single,
        _ => Kind::Pair,
    }
}

#[cfg(test)]
mod tests {
    use world::Effect;

    #[test]
    fn a_label_and_the_card_of_an_effect_name_one_port() {
        for effect in Effect::ALL {
            let known = effects::find(effect.name()).expect("an effect of the library");
            assert_eq!(effect.port().name(), known.card().port.name(), "{}", effect.name());
        }
    }
}
