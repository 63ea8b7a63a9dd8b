//! Material updates compiled once, in this crate: every material that a scene may name, over `f64` in the plane and in space, and over
//! jets. A material from outside compiles its own.

use std::any::Any;

use perturbation_moments::Jet;

use crate::material::{
    ElasticBulk, ElasticShear, Fluid, JohnsonCook, JohnsonCookDamage, Jwl, MieGruneisen,
    NeoHookean, Solid, StiffenedGas, TensionCutOff, VonMises,
};
use crate::material_points::UpdateBatch;

type Liquid<S> = Solid<MieGruneisen<S>, Fluid>;
type CavitatingLiquid<S> = Solid<TensionCutOff<MieGruneisen<S>, S>, Fluid>;
type Gas<S> = Solid<StiffenedGas<S>, Fluid>;
type Explosive<S> = Solid<Jwl<S>, Fluid>;
type Elastic<S> = Solid<ElasticBulk<S>, ElasticShear<S>>;
type Plastic<S> = Solid<ElasticBulk<S>, VonMises<S>>;
type ShockedElastic<S> = Solid<MieGruneisen<S>, ElasticShear<S>>;
type ShockedPlastic<S> = Solid<MieGruneisen<S>, VonMises<S>>;
type Metal<S> = Solid<MieGruneisen<S>, JohnsonCook<S>>;
type BreakingMetal<S> = Solid<MieGruneisen<S>, JohnsonCookDamage<S>>;

macro_rules! of {
    ($($material:ident),+ $(,)?) => {
        [$(
            [
                &UpdateBatch::<$material<f64>, f64, true>::HERE as &(dyn Any + Send + Sync),
                &UpdateBatch::<$material<f64>, f64, false>::HERE,
                &UpdateBatch::<$material<Jet>, Jet, false>::HERE,
            ]
        ),+]
    };
}

/// All compiled updates.
#[inline(never)]
pub(crate) fn updates() -> &'static [&'static (dyn Any + Send + Sync)] {
    static ALL: [[&(dyn Any + Send + Sync); 3]; 11] = of![
        Liquid,
        CavitatingLiquid,
        Gas,
        Explosive,
        Elastic,
        Plastic,
        ShockedElastic,
        ShockedPlastic,
        Metal,
        BreakingMetal,
        NeoHookean,
    ];
    ALL.as_flattened()
}
