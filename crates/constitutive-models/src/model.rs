//! The materials of this crate as one type: what a program chooses between at run time.

use crate::{
    ElasticBulk, ElasticShear, Fluid, JohnsonCook, JohnsonCookDamage, Jwl, Material, MieGruneisen,
    NeoHookean, Solid, StiffenedGas, TensionCutOff, VonMises,
};
use perturbation_moments::Scalar;

/// A variant for each material, which is made from it by [`From`].
macro_rules! models {
    ($($(#[$about:meta])+ $name:ident($material:ty)),+ $(,)?) => {
        /// A material of this crate, over a number type. Programs that step many particles compile each of them once.
        #[derive(Debug, Clone, Copy, PartialEq)]
        pub enum Model<S> {
            $($(#[$about])+ $name($material)),+
        }

        $(
            impl<S> From<$material> for Model<S> {
                fn from(material: $material) -> Self {
                    Self::$name(material)
                }
            }
        )+

        impl<S: Scalar + std::fmt::Debug + Send + Sync> Model<S> {
            /// `rho_0 > 0`, the density of the reference state (mass per volume).
            #[must_use]
            pub fn density(&self) -> S {
                match self {
                    $(Self::$name(material) => material.density()),+
                }
            }
        }
    };
}

models! {
    /// A liquid, or a solid under pressures far above its strength.
    Liquid(Solid<MieGruneisen<S>, Fluid>),
    /// A liquid that bears no more than a tension.
    CavitatingLiquid(Solid<TensionCutOff<MieGruneisen<S>, S>, Fluid>),
    /// A gas.
    Gas(Solid<StiffenedGas<S>, Fluid>),
    /// An explosive.
    Explosive(Solid<Jwl<S>, Fluid>),
    /// A linear elastic solid.
    Elastic(Solid<ElasticBulk<S>, ElasticShear<S>>),
    /// An elastic solid that yields at a constant stress.
    Plastic(Solid<ElasticBulk<S>, VonMises<S>>),
    /// An elastic solid under shocks.
    ShockedElastic(Solid<MieGruneisen<S>, ElasticShear<S>>),
    /// An elastic solid under shocks that yields at a constant stress.
    ShockedPlastic(Solid<MieGruneisen<S>, VonMises<S>>),
    /// A metal, whose flow stress depends on strain, rate and temperature.
    Metal(Solid<MieGruneisen<S>, JohnsonCook<S>>),
    /// A metal that breaks.
    BreakingMetal(Solid<MieGruneisen<S>, JohnsonCookDamage<S>>),
    /// Rubber.
    Rubber(NeoHookean<S>),
}

impl<S> Model<S> {
    /// Whether its constants may differ from particle to particle.
    #[must_use]
    pub const fn can_vary(&self) -> bool {
        matches!(self, Self::Elastic(_) | Self::ShockedPlastic(_) | Self::Metal(_))
    }
}
