//! Enumerations whose variants have names: [`named!`].

/// Declares a public enumeration whose variants have names: each variant stands once, with the name that
/// files and messages use. It is copied, ordered as written and displayed by its name, and has `ALL`,
/// `name` and `from_name`.
///
/// ```
/// named::named! {
///     /// When something is eaten.
///     Meal {
///         /// In the morning.
///         Breakfast: "breakfast",
///         /// In the evening.
///         Dinner: "dinner",
///     }
/// }
///
/// assert_eq!(Meal::ALL.map(Meal::name), ["breakfast", "dinner"]);
/// assert_eq!(Meal::from_name("dinner"), Some(Meal::Dinner));
/// assert_eq!(Meal::Dinner.to_string(), "dinner");
/// ```
#[macro_export]
macro_rules! named {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $variant:ident: $word:literal,)+ }) => {
        $(#[$about])*
        #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
        pub enum $name { $($(#[$doc])* $variant,)+ }

        impl $name {
            /// Every variant, in its order.
            pub const ALL: [Self; [$($word),+].len()] = [$(Self::$variant),+];

            /// The name that files and messages use.
            #[must_use]
            pub const fn name(self) -> &'static str {
                match self { $(Self::$variant => $word,)+ }
            }

            /// The variant of a name; `None` for an unknown name.
            #[must_use]
            pub fn from_name(name: &str) -> Option<Self> {
                Self::ALL.into_iter().find(|variant| variant.name() == name)
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str(self.name())
            }
        }
    };
}

/// The same for names that stand in JSON too: the enumeration derives serde's traits and is written by its names.
///
/// ```
/// named::named_in_json! {
///     /// When something is eaten.
///     #[derive(serde::Serialize, serde::Deserialize)]
///     Meal {
///         /// In the morning.
///         Breakfast: "at breakfast",
///     }
/// }
///
/// assert_eq!(serde_json::to_string(&Meal::Breakfast)?, "\"at breakfast\"");
/// # Ok::<(), serde_json::Error>(())
/// ```
#[macro_export]
macro_rules! named_in_json {
    ($(#[$about:meta])* $name:ident { $($(#[$doc:meta])* $variant:ident: $word:literal,)+ }) => {
        $crate::named! {
            $(#[$about])*
            $name { $($(#[$doc])* #[serde(rename = $word)] $variant: $word,)+ }
        }
    };
}
