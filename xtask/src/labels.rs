//! The label of a world: what `world` made, in the words in which `blind` scores.

use blind::{Kind, Label, TrueEffect};
use world::Regime;
use world::blind::{PlannedWorld, RealisedWorld};

/// The label of a world under the name `id`.
pub(crate) fn label(id: &str, world: &RealisedWorld) -> Label {
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
    Label {
        id: id.to_owned(),
        kind: kind(planned),
        effects,
        generator: planned.generator.name().to_owned(),
        regime: regime(planned.regime).to_owned(),
        people: planned.people,
        days: planned.days,
        nuisances: planned.nuisances.words(),
        seed: planned.seed,
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

fn regime(regime: Regime) -> &'static str {
    match regime {
        Regime::OpenLoopPump => "open_loop_pump",
        Regime::Aid => "aid",
        Regime::Mdi => "mdi",
    }
}
