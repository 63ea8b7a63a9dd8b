//! Material points compiled once, in this crate: every material that a scene may name, over `f64` several particles at once, over
//! jets one by one. A material from outside compiles its own.

use std::any::Any;

use perturbation_moments::Jet;

use crate::points::material_points::{MaterialPoints, Points};
use crate::points::points_in_lanes::PointsInLanes;
use constitutive_models::{
    ElasticBulk, ElasticShear, Fluid, JohnsonCook, JohnsonCookDamage, Jwl, Material,
    MaterialFamily, MieGruneisen, NeoHookean, Solid, StiffenedGas, TensionCutOff, Varying,
    VonMises,
};

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

/// How a body's particles are made of a material: whether motion stays in the plane of the first two axes, and their places.
pub(crate) type Make<M, S> = fn(M, bool, &[[f64; 3]]) -> Box<dyn MaterialPoints<S>>;

/// The same of a material whose constants vary, by that of each particle.
pub(crate) type MakeVarying<M, S> = fn(&[M], bool, &[[f64; 3]]) -> Box<dyn MaterialPoints<S>>;

fn in_lanes<M: MaterialFamily<f64> + 'static>(
    material: M,
    plane: bool,
    places: &[[f64; 3]],
) -> Box<dyn MaterialPoints<f64>> {
    Box::new(PointsInLanes::at_start(material, plane, places))
}

fn one_by_one<M: Material<Jet, State: 'static> + 'static>(
    material: M,
    plane: bool,
    places: &[[f64; 3]],
) -> Box<dyn MaterialPoints<Jet>> {
    Box::new(Points::at_start(material, plane, places))
}

fn varying_in_lanes<M: MaterialFamily<f64, State: 'static> + Copy + 'static>(
    materials: &[M],
    plane: bool,
    places: &[[f64; 3]],
) -> Box<dyn MaterialPoints<f64>> {
    let starts = Varying::starts::<f64>(materials, places);
    Box::new(PointsInLanes::of_states(Varying::like(materials[0]), plane, &starts))
}

fn varying_one_by_one<M: Material<Jet, State: 'static> + Copy + 'static>(
    materials: &[M],
    plane: bool,
    places: &[[f64; 3]],
) -> Box<dyn MaterialPoints<Jet>> {
    let starts = Varying::starts::<Jet>(materials, places);
    Box::new(Points::of_states(Varying::like(materials[0]), plane, starts))
}

macro_rules! of {
    ($make:ident, $in_lanes:ident, $one_by_one:ident: $($material:ident),+ $(,)?) => {
        [$(
            [
                &($in_lanes::<$material<f64>> as $make<$material<f64>, f64>)
                    as &(dyn Any + Send + Sync),
                &($one_by_one::<$material<Jet>> as $make<$material<Jet>, Jet>),
            ]
        ),+]
    };
}

/// All of them.
#[inline(never)]
pub(crate) fn makers() -> &'static [&'static (dyn Any + Send + Sync)] {
    static ALL: [[&(dyn Any + Send + Sync); 2]; 11] = of![
        Make, in_lanes, one_by_one:
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

/// Those whose constants a scene may let vary from particle to particle.
#[inline(never)]
pub(crate) fn varying_makers() -> &'static [&'static (dyn Any + Send + Sync)] {
    static ALL: [[&(dyn Any + Send + Sync); 2]; 3] = of![
        MakeVarying, varying_in_lanes, varying_one_by_one:
        Elastic,
        ShockedPlastic,
        Metal,
    ];
    ALL.as_flattened()
}
