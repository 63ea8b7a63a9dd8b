//! Scene enums that mirror enums of the solver.

/// An enum of keys that maps to an enum of the solver.
macro_rules! named {
    ($(#[$meta:meta])* $scene:ident => $target:ident { $($(#[$variant_meta:meta])* $variant:ident,)+ }) => {
        $(#[$meta])*
        #[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
        #[serde(rename_all = "snake_case")]
        pub enum $scene { $($(#[$variant_meta])* $variant,)+ }

        impl From<$scene> for $target {
            fn from(scene: $scene) -> Self {
                match scene { $($scene::$variant => Self::$variant,)+ }
            }
        }
    };
}
pub(crate) use named;
