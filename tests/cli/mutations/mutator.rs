//! Changes of a scene such as slips of the pen, copied sections and odd ideas make.

use toml::{Table, Value};

use super::random::Random;

/// One step on the way to a value.
#[derive(Clone)]
enum Step {
    Key(String),
    Index(usize),
}

/// A text made from one of the bases by one to three changes, all told by the seed.
pub fn mutated(bases: &[Table], seed: u64) -> String {
    let mut random = Random::new(seed);
    let mut scene = random.pick(bases).clone();
    for _ in 0..=random.below(3) {
        change(&mut scene, bases, &mut random);
    }
    let text = toml::to_string(&scene).unwrap();
    match random.below(20) {
        0 => slip(&text, &mut random),
        _ => text,
    }
}

fn change(scene: &mut Table, bases: &[Table], random: &mut Random) {
    let paths = paths(scene);
    if paths.is_empty() {
        return;
    }
    let path = random.pick(&paths).clone();
    match random.below(12) {
        0 => drop(take(scene, &path)),
        1 => rename(scene, &path, random),
        2 => copy_over(scene, &path, &paths, random),
        3 => move_section(scene, bases, random),
        4 => other_word(scene, &path, bases, random),
        5 => set_choice(scene, random),
        _ => {
            if let Some(value) = find(scene, &path) {
                disturb(value, random);
            }
        }
    }
}

/// Every value in tables and lists.
fn paths(scene: &Table) -> Vec<Vec<Step>> {
    fn walk(value: &Value, path: &mut Vec<Step>, found: &mut Vec<Vec<Step>>) {
        found.push(path.clone());
        let children: Vec<(Step, &Value)> = match value {
            Value::Table(table) => table
                .iter()
                .map(|(k, v)| (Step::Key(k.clone()), v))
                .collect(),
            Value::Array(list) => list
                .iter()
                .enumerate()
                .map(|(i, v)| (Step::Index(i), v))
                .collect(),
            _ => Vec::new(),
        };
        for (step, child) in children {
            path.push(step);
            walk(child, path, found);
            path.pop();
        }
    }
    let mut found = Vec::new();
    for (key, value) in scene {
        walk(value, &mut vec![Step::Key(key.clone())], &mut found);
    }
    found
}

fn find<'a>(scene: &'a mut Table, path: &[Step]) -> Option<&'a mut Value> {
    let (first, rest) = path.split_first()?;
    let Step::Key(key) = first else { return None };
    rest.iter()
        .try_fold(scene.get_mut(key)?, |value, step| match step {
            Step::Key(key) => value.as_table_mut()?.get_mut(key),
            Step::Index(index) => value.as_array_mut()?.get_mut(*index),
        })
}

/// Takes a value out of its table or list.
fn take(scene: &mut Table, path: &[Step]) -> Option<Value> {
    let (last, parents) = path.split_last()?;
    match (last, parents) {
        (Step::Key(key), []) => scene.remove(key),
        (Step::Key(key), _) => find(scene, parents)?.as_table_mut()?.remove(key),
        (Step::Index(index), _) => {
            let list = find(scene, parents)?.as_array_mut()?;
            (*index < list.len()).then(|| list.remove(*index))
        }
    }
}

fn put(scene: &mut Table, path: &[Step], value: Value) {
    let Some((last, parents)) = path.split_last() else {
        return;
    };
    match (last, parents) {
        (Step::Key(key), []) => drop(scene.insert(key.clone(), value)),
        (Step::Key(key), _) => {
            if let Some(table) = find(scene, parents).and_then(Value::as_table_mut) {
                table.insert(key.clone(), value);
            }
        }
        (Step::Index(_), _) => {
            if let Some(list) = find(scene, parents).and_then(Value::as_array_mut) {
                list.push(value);
            }
        }
    }
}

/// The last key with two letters swapped, one lost, or one added.
fn rename(scene: &mut Table, path: &[Step], random: &mut Random) {
    let Some((Step::Key(key), parents)) = path.split_last() else {
        return;
    };
    let mut letters: Vec<char> = key.chars().collect();
    let at = random.below(letters.len());
    match random.below(3) {
        0 if at + 1 < letters.len() => letters.swap(at, at + 1),
        1 => drop(letters.remove(at)),
        _ => letters.insert(at, 's'),
    }
    if let Some(value) = take(scene, path) {
        let own = Step::Key(letters.into_iter().collect());
        put(scene, &[parents, &[own]].concat(), value);
    }
}

/// A value put where another one was, or beside itself.
fn copy_over(scene: &mut Table, path: &[Step], paths: &[Vec<Step>], random: &mut Random) {
    let from: &Vec<Step> = random.pick(paths);
    let Some(value) = find(scene, from).cloned() else {
        return;
    };
    match path.last() {
        Some(Step::Key(key)) if random.below(3) == 0 => {
            let twin = Step::Key(format!("{key}-2"));
            let parents = &path[..path.len() - 1];
            let own = find(scene, path).cloned().unwrap_or(value);
            put(scene, &[parents, &[twin]].concat(), own);
        }
        _ => {
            if let Some(place) = find(scene, path) {
                *place = value;
            }
        }
    }
}

/// A section of another scene in place of the own one, or in addition.
fn move_section(scene: &mut Table, bases: &[Table], random: &mut Random) {
    let other = random.pick(bases);
    let keys: Vec<&String> = other.keys().collect();
    let key: &&String = random.pick(&keys);
    scene.insert((*key).clone(), other[*key].clone());
}

/// A text of any scene in place of another one.
fn other_word(scene: &mut Table, path: &[Step], bases: &[Table], random: &mut Random) {
    let mut other = random.pick(bases).clone();
    let others = paths(&other);
    let from: &Vec<Step> = random.pick(&others);
    let word = find(&mut other, from).cloned();
    if let (Some(word @ Value::String(_)), Some(place)) = (word, find(scene, path)) {
        *place = word;
    }
}

/// Choices that bundled scenes hardly make.
const CHOICES: [(&str, &str, &[&str]); 23] = [
    (
        "scheme",
        "name",
        &[
            "implicit",
            "explicit",
            "semi-implicit",
            "staggered",
            "monolithic",
        ],
    ),
    ("scheme", "solid", &["switched", "adr", "verlet"]),
    ("scheme", "start", &["assembled", "relaxed"]),
    ("scheme", "adr_damping", &["global", "local"]),
    ("scheme", "acceleration", &["anderson", "aitken", "none"]),
    ("mechanics", "mode", &["dynamic", "quasi-static"]),
    (
        "mechanics",
        "gradient",
        &["auto", "plain", "divergence-consistent"],
    ),
    ("flow", "operator", &["bond", "correspondence", "auto"]),
    (
        "flow",
        "gradient",
        &["auto", "plain", "divergence-consistent"],
    ),
    ("time", "mode", &["steady", "transient"]),
    ("time", "integrator", &["tr-bdf2", "backward-euler"]),
    (
        "horizon",
        "influence",
        &["inverse", "constant", "gaussian", "inverse-square"],
    ),
    (
        "damage",
        "split",
        &["spectral", "volumetric-deviatoric", "none"],
    ),
    ("damage", "method", &["auto", "newton", "alternate"]),
    ("damage", "hourglass", &["variational", "linear"]),
    ("fracture_flow", "aperture", &["normal", "mean"]),
    ("fracture_flow", "transmissivity", &["cubic", "paper"]),
    (
        "solver",
        "name",
        &[
            "auto", "faer-llt", "faer-lu", "faer-cg", "gmres", "fgmres", "minres",
        ],
    ),
    ("coupling", "stabilisation", &["0", "0.5", "20"]),
    ("coupling", "undrained_start", &["true", "false"]),
    ("geometry", "jitter", &["0.1", "0.3", "0.5"]),
    ("horizon", "ratio", &["1", "1.5", "3.1", "8", "100"]),
    ("horizon", "neighbours", &["2", "4", "30", "5000"]),
];

fn set_choice(scene: &mut Table, random: &mut Random) {
    let (section, key, words) = random.pick(&CHOICES);
    let word = *random.pick(words);
    let value = match word.parse::<Value>() {
        Ok(value) => value,
        Err(_) => Value::String(word.to_owned()),
    };
    let table = scene
        .entry(*section)
        .or_insert_with(|| Value::Table(Table::new()));
    if let Some(table) = table.as_table_mut() {
        table.insert((*key).to_owned(), value);
    }
}

const FACTORS: [f64; 12] = [
    0.0, -1.0, 0.5, 2.0, 3.0, 10.0, 0.1, 1e3, 1e-3, 1e6, 1e-9, 1e12,
];
const EXTREMES: [f64; 8] = [
    f64::NAN,
    f64::INFINITY,
    f64::NEG_INFINITY,
    1e300,
    -1e300,
    5e-324,
    1e-300,
    1.797e308,
];
const UNITS: [&str; 12] = [
    "Pa", "MPa", "m", "mm", "s", "h", "mD", "cP", "kg/m^3", "m^2/s", "%", "furlong",
];

fn disturb(value: &mut Value, random: &mut Random) {
    if random.below(8) == 0 {
        *value = other_kind(random);
        return;
    }
    match value {
        Value::Integer(number) => *value = number_of(*number as f64, true, random),
        Value::Float(number) => *value = number_of(*number, false, random),
        Value::Boolean(flag) => *flag = !*flag,
        Value::String(text) => *text = quantity(text, random),
        Value::Array(list) => match random.below(4) {
            0 => drop(list.pop()),
            1 => list.extend(list.last().cloned()),
            2 => list.reverse(),
            _ => list.clear(),
        },
        Value::Table(table) => match random.below(4) {
            0 => table.clear(),
            _ => {
                table.insert("extra".to_owned(), Value::Integer(1));
            }
        },
        Value::Datetime(_) => {}
    }
}

fn number_of(number: f64, whole: bool, random: &mut Random) -> Value {
    if random.below(4) == 0 {
        return Value::Float(*random.pick(&EXTREMES));
    }
    let scaled = number * random.pick(&FACTORS);
    match whole && scaled.abs() < 9e18 {
        true => Value::Integer(scaled as i64),
        false => Value::Float(scaled),
    }
}

/// A quantity with another number or another unit; a word with a letter lost.
fn quantity(text: &str, random: &mut Random) -> String {
    let Some((number, unit)) = text.split_once(' ') else {
        return text.chars().skip(1).collect();
    };
    match number.parse::<f64>() {
        Ok(_) if random.below(3) == 0 => format!("{number} {}", random.pick(&UNITS)),
        Ok(number) if random.below(5) == 0 => format!("{number}{unit}{unit}"),
        Ok(number) => format!("{:e} {unit}", number * random.pick(&FACTORS)),
        Err(_) => text.chars().rev().collect(),
    }
}

fn other_kind(random: &mut Random) -> Value {
    match random.below(8) {
        0 => Value::Boolean(true),
        1 => Value::Integer(i64::MAX),
        2 => Value::String(String::new()),
        3 => Value::String("1 m".to_owned()),
        4 => Value::Array(Vec::new()),
        5 => Value::Array(vec![Value::Float(0.5); 3]),
        6 => Value::Table(Table::new()),
        _ => Value::Float(-1.5),
    }
}

/// A line lost or given twice, or a character lost.
fn slip(text: &str, random: &mut Random) -> String {
    let mut lines: Vec<&str> = text.lines().collect();
    let at = random.below(lines.len());
    match random.below(3) {
        0 => drop(lines.remove(at)),
        1 => lines.insert(at, lines[at]),
        _ => {
            let lost = random.below(text.chars().count());
            let kept = text.chars().enumerate().filter(|(index, _)| *index != lost);
            return kept.map(|(_, letter)| letter).collect();
        }
    }
    lines.join("\n")
}
