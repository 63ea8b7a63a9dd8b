//! Constants of models by the fields of cards, in the units of a scene.
//!
//! Layout: manual of LS-DYNA, volume II. Compared with public descriptions were `MAT_015` and the first line of `EOS_GRUNEISEN`; the
//! others are from memory.

use std::collections::{BTreeMap, BTreeSet};

use result_figures::number::tidy;
use scene_runs::scene::Objection;
use smpm::material::Units;

use super::cards::{Card, CardKind, Cards};
use crate::material_part::{MaterialPart, Numbers};
use crate::material_units::unit;

const JOHNSON_COOK: CardKind = (
    "MAT_JOHNSON_COOK",
    "MAT_015",
    &[
        "MID RO G E PR DTF VP RATEOP",
        "A B N C M TM TR EPSO",
        "CP PC SPALL IT D1 D2 D3 D4",
        "D5 C2 EROD EFMIN NUMINT K EPS1 DMODEL",
    ],
);
const PLASTIC_KINEMATIC: CardKind =
    ("MAT_PLASTIC_KINEMATIC", "MAT_003", &["MID RO E PR SIGY ETAN BETA", "SRC SRP FS VP"]);
const EXPLOSIVE: CardKind = ("MAT_HIGH_EXPLOSIVE_BURN", "MAT_008", &["MID RO D PCJ BETA K G SIGY"]);
const GRUNEISEN: CardKind =
    ("EOS_GRUNEISEN", "EOS_004", &["EOSID C S1 S2 S3 GAMAO A E0", "V0 - LCID"]);
const JWL: CardKind = ("EOS_JWL", "EOS_002", &["EOSID A B R1 R2 OMEG E0 V0"]);

/// Constants of a material that its scene leaves to a file: part, model and names.
pub(crate) type Wanted = Vec<(MaterialPart, &'static str, Vec<&'static str>)>;

/// Constants of a file, in the units of the scene.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Constants {
    pub(crate) numbers: Numbers,
    /// Keywords and ids of the cards, each with the fields that have no effect here.
    pub(crate) cards: Vec<(String, Vec<String>)>,
}

impl Constants {
    /// Reads what is wanted of the cards; `ids` are those of material and equation of state.
    pub(crate) fn of(
        cards: &Cards<'_>,
        wanted: &Wanted,
        ids: [Option<u64>; 2],
        [from, to]: [&Units; 2],
    ) -> Result<Self, Objection> {
        let mut read: BTreeMap<&str, (Card, BTreeSet<&str>)> = BTreeMap::new();
        let mut numbers = Numbers::new();
        for (part, model, names) in wanted {
            for name in names {
                let Some((kind, field)) = place(model, name, wanted) else { continue };
                if !read.contains_key(kind.0) {
                    let card = cards.card(kind, ids[usize::from(kind.0.starts_with("EOS"))])?;
                    read.insert(kind.0, (card, BTreeSet::new()));
                }
                let Some((card, used)) = read.get_mut(kind.0) else { continue };
                let (value, others) = value(card, field).map_err(|message| {
                    let message = format!("{} of {}: {message}", card.name, cards.file);
                    let help = format!("write \"{name}\" under `set`, which is taken instead");
                    Objection::new(cards.key, message).with_help(help)
                })?;
                used.extend(others.iter().chain([&field]));
                numbers.insert((*part, *name), unit(name).1(to, value / unit(name).1(from, 1.0)));
            }
        }
        let mut found = Self { numbers, cards: Vec::new() };
        for (keyword, (card, used)) in read {
            let others = card.numbers.iter().filter(|(field, value)| {
                !used.contains(*field) && **value != 0.0 && !NEUTRAL.contains(&(**field, **value))
            });
            let mut unused = Vec::new();
            for (field, value) in others.filter(|(field, _)| !["MID", "EOSID"].contains(*field)) {
                unused.push(format!("{field} {}", tidy(*value)));
                if let Some(meaning) = unsupported(keyword, field) {
                    let value = tidy(*value);
                    let message = format!("{field} is {value}: {meaning} is not supported");
                    let message = format!("{} of {}: {message}", card.name, cards.file);
                    return Err(Objection::new(cards.key, message));
                }
            }
            found.cards.push((card.name, unused));
        }
        Ok(found)
    }
}

/// Card and field of a constant; the density of `mie_gruneisen` is that of the strength.
fn place(model: &str, name: &'static str, wanted: &Wanted) -> Option<(CardKind, &'static str)> {
    let strength = wanted.iter().find(|it| it.0 == MaterialPart::Strength).map(|it| it.1);
    let kind = match (model, name) {
        ("mie_gruneisen", "density") => return place(strength?, name, &Vec::new()),
        ("mie_gruneisen", _) => GRUNEISEN,
        ("jwl", "density" | "detonation_speed") => EXPLOSIVE,
        ("jwl", _) => JWL,
        ("von_mises", _) => PLASTIC_KINEMATIC,
        ("johnson_cook" | "damage", _) => JOHNSON_COOK,
        _ => return None,
    };
    let field = match name {
        "density" => "RO",
        "sound_speed" => "C",
        "gruneisen" => "GAMAO",
        "gruneisen_slope" => "A",
        "detonation_speed" => "D",
        "omega" => "OMEG",
        "energy" => "E0",
        "shear_modulus" if model == "von_mises" => "E",
        "shear_modulus" => "G",
        "yield_stress" => "SIGY",
        "hardening_modulus" => "ETAN",
        "reference_rate" => "EPSO",
        "room_temperature" => "TR",
        "melting_temperature" => "TM",
        "specific_heat" => "CP",
        "spall_strength" => "PC",
        // The others have the same letters.
        _ => kind
            .2
            .iter()
            .flat_map(|line| line.split(' '))
            .find(|it| it.eq_ignore_ascii_case(name))?,
    };
    Some((kind, field))
}

/// Numbers of fields that say what holds here anyway.
const NEUTRAL: [(&str, f64); 4] = [("BETA", 2.0), ("EFMIN", 1e-6), ("FS", 1e20), ("V0", 1.0)];

/// What a field means that changes the material and that no model here has.
fn unsupported(keyword: &str, field: &str) -> Option<&'static str> {
    Some(match (keyword, field) {
        ("MAT_JOHNSON_COOK", "RATEOP") => "a flow stress not linear in the logarithm of the rate",
        ("MAT_JOHNSON_COOK", "DMODEL") => "a damage that is not that of Johnson and Cook",
        ("MAT_JOHNSON_COOK", "EFMIN") => "a least strain at fracture other than 1e-6",
        ("MAT_PLASTIC_KINEMATIC", "SRC" | "SRP") => "the rate law of Cowper and Symonds",
        ("MAT_PLASTIC_KINEMATIC", "FS") => "failure at a plastic strain",
        ("MAT_HIGH_EXPLOSIVE_BURN", "BETA") => "burn by compression alone",
        ("EOS_GRUNEISEN", "E0" | "LCID") => "an energy at the start",
        (_, "V0") => "a volume at the start other than 1",
        _ => return None,
    })
}

/// The number of a field, or what follows from it with others, which are returned too.
fn value(card: &Card, field: &str) -> Result<(f64, &'static [&'static str]), String> {
    let [young, poisson, beta, spall] = ["E", "PR", "BETA", "SPALL"].map(|name| card.of(name));
    let (number, shear) = (card.of(field), young / (2.0 * (1.0 + poisson)));
    Ok(match field {
        "E" => (shear, &["PR"]),
        "G" if number == 0.0 => (shear, &["E", "PR"]),
        "ETAN" if number == 0.0 => (0.0, &["BETA"]),
        "ETAN" if number >= young => return Err("ETAN is not below E".to_owned()),
        "ETAN" if beta.to_bits() == 1f64.to_bits() => {
            (young * number / (young - number), &["BETA"])
        }
        "ETAN" => {
            let beta = tidy(beta);
            return Err(format!(
                "BETA is {beta}; of hardening only the isotropic, 1, is supported"
            ));
        }
        "D1" if ["D1", "D2", "D3", "D4", "D5"].iter().all(|name| card.of(name) == 0.0) => {
            (f64::INFINITY, &[])
        }
        "PC" if number == 0.0 => (f64::INFINITY, &["SPALL"]),
        "PC" if number > 0.0 => return Err("PC is above 0; a tension is below".to_owned()),
        "PC" if spall.to_bits() == 3f64.to_bits() => (-number, &["SPALL"]),
        "PC" => {
            let spall = tidy(spall);
            return Err(format!("SPALL is {spall}; only 3, spall by pressure, is supported"));
        }
        _ => (number, &[]),
    })
}
