//! Meshes from input files of Abaqus: nodes, elements, and their sets.
//!
//! Keywords that say nothing of these are skipped. One part is read, in its own coordinates; what would
//! move, copy or generate nodes is refused by name.

mod kinds;

use std::collections::HashMap;
use std::path::Path;

use super::{Element, ElementKind, Group, Mesh};
use crate::plan::files::{FileError, Place, utf8};
use kinds::kind_of;

/// Reads a mesh; see [`super::read_mesh`].
pub(super) fn read(path: &Path, bytes: &[u8]) -> Result<Mesh, FileError> {
    let mut file = File {
        path,
        line: 0,
        mesh: Mesh::default(),
        node: HashMap::new(),
        element: HashMap::new(),
        parts: 0,
    };
    let mut section = Section::Other;
    for (number, line) in (1..).zip(utf8(path, bytes)?.lines()) {
        file.line = number;
        let line = line.trim();
        if line.is_empty() || line.starts_with("**") {
            continue;
        }
        match line.strip_prefix('*') {
            Some(keyword) => {
                file.complete(&section)?;
                section = file.keyword(keyword)?;
            }
            None => file.data(&mut section, line)?,
        }
    }
    file.complete(&section)?;
    Ok(file.mesh)
}

/// What the lines after a keyword hold.
enum Section {
    /// Nothing of the mesh.
    Other,
    /// Nodes, of a set if one is named.
    Nodes { set: Option<String> },
    /// Elements of a form, of a set if one is named; `open` are the numbers of one that goes on in the next line.
    Elements {
        kind: ElementKind,
        set: Option<String>,
        open: Vec<u64>,
    },
    /// Members of a set, as numbers and names of other sets or, if `generate`, as ranges.
    Set {
        name: String,
        of_nodes: bool,
        generate: bool,
    },
    /// An instance of a part: a line would move it.
    Instance,
}

/// Keywords that make or move nodes and elements in ways that are not followed.
const REFUSED: [&str; 9] = [
    "NGEN",
    "NFILL",
    "NCOPY",
    "NMAP",
    "ELGEN",
    "ELCOPY",
    "SYSTEM",
    "INCLUDE",
    "TRANSFORM NODES",
];

struct File<'a> {
    path: &'a Path,
    /// Line that is read, from 1.
    line: usize,
    mesh: Mesh,
    /// Places of nodes by their numbers.
    node: HashMap<u64, u32>,
    /// Places of elements by their numbers.
    element: HashMap<u64, u32>,
    parts: usize,
}

impl File<'_> {
    fn keyword(&mut self, text: &str) -> Result<Section, FileError> {
        let (word, given) = options(text);
        let value = |key: &str| {
            let found = given.iter().find(|(own, _)| own == key);
            found.map(|(_, value)| (*value).to_owned())
        };
        if REFUSED.contains(&word.as_str()) {
            let remedy = "write all nodes and elements out, for instance by saving the mesh from the preprocessor";
            return Err(self.unsupported("the keyword", format!("*{word}"), remedy));
        }
        Ok(match word.as_str() {
            "NODE" => Section::Nodes { set: value("NSET") },
            "ELEMENT" => Section::Elements {
                kind: self.kind(&value("TYPE").unwrap_or_default())?,
                set: value("ELSET"),
                open: Vec::new(),
            },
            "NSET" | "ELSET" => Section::Set {
                name: value(&word).ok_or_else(|| self.damaged(format!("*{word} has no name")))?,
                of_nodes: word == "NSET",
                generate: value("GENERATE").is_some(),
            },
            "SOLID SECTION" => self.section(value("ELSET"), value("MATERIAL")),
            "PART" => self.part()?,
            "INSTANCE" => Section::Instance,
            _ => Section::Other,
        })
    }

    fn part(&mut self) -> Result<Section, FileError> {
        self.parts += 1;
        match self.parts {
            1 => Ok(Section::Other),
            _ => {
                let remedy = "merge the parts into one, or write one part to a file";
                Err(self.unsupported("the keyword", "a second *PART".to_owned(), remedy))
            }
        }
    }

    /// The elements that have a material are a group of its name.
    fn section(&mut self, set: Option<String>, material: Option<String>) -> Section {
        if let (Some(set), Some(material)) = (set, material) {
            let members = members(&self.mesh.groups, &set).map(<[u32]>::to_vec);
            add(
                &mut self.mesh.groups,
                &material,
                members.unwrap_or_default(),
            );
        }
        Section::Other
    }

    fn data(&mut self, section: &mut Section, line: &str) -> Result<(), FileError> {
        match section {
            Section::Other => Ok(()),
            Section::Nodes { set } => self.node(set.as_deref(), line),
            Section::Elements { kind, set, open } => {
                for word in words(line) {
                    open.push(self.number(word)?);
                }
                let whole = 1 + kind.corners().unwrap_or(0);
                match open.len() {
                    found if found < whole => Ok(()),
                    found if found > whole => Err(self.damaged(format!(
                        "element {} has {} nodes, and a {} has {}",
                        open[0],
                        found - 1,
                        kind.name(),
                        whole - 1
                    ))),
                    _ => self.element(*kind, set.as_deref(), &std::mem::take(open)),
                }
            }
            Section::Set {
                name,
                of_nodes,
                generate,
            } => self.members(name, (*of_nodes, *generate), line),
            Section::Instance => {
                let remedy = "write the mesh of the assembly as one part in its own coordinates";
                Err(self.unsupported("the position of an instance", line.to_owned(), remedy))
            }
        }
    }

    fn complete(&self, section: &Section) -> Result<(), FileError> {
        match section {
            Section::Elements { open, .. } if !open.is_empty() => {
                Err(self.damaged(format!("element {} lacks nodes", open[0])))
            }
            _ => Ok(()),
        }
    }

    fn node(&mut self, set: Option<&str>, line: &str) -> Result<(), FileError> {
        let mut words = line.split(',').map(str::trim);
        let number = self.number(words.next().unwrap_or(""))?;
        let mut node = [0.0; 3];
        for (x, word) in node
            .iter_mut()
            .zip(words)
            .filter(|(_, word)| !word.is_empty())
        {
            *x = word
                .to_lowercase()
                .replace('d', "e")
                .parse()
                .map_err(|_| self.damaged(format!("`{word}` is no coordinate")))?;
        }
        let place = self.mesh.nodes.len() as u32;
        if self.node.insert(number, place).is_some() {
            return Err(self.damaged(format!("node {number} is there twice")));
        }
        self.mesh.nodes.push(node);
        if let Some(set) = set {
            add(&mut self.mesh.node_groups, set, [place]);
        }
        Ok(())
    }

    fn element(
        &mut self,
        kind: ElementKind,
        set: Option<&str>,
        numbers: &[u64],
    ) -> Result<(), FileError> {
        let label = numbers[0];
        let mut nodes = Vec::with_capacity(numbers.len() - 1);
        for number in &numbers[1..] {
            let place = self.node.get(number).copied();
            nodes.push(place.ok_or_else(|| {
                self.damaged(format!(
                    "element {label} has node {number}, which is not there"
                ))
            })?);
        }
        let place = self.mesh.elements.len() as u32;
        if self.element.insert(label, place).is_some() {
            return Err(self.damaged(format!("element {label} is there twice")));
        }
        self.mesh.elements.push(Element { label, kind, nodes });
        if let Some(set) = set {
            add(&mut self.mesh.groups, set, [place]);
        }
        Ok(())
    }

    /// Adds the members that a line of a set names.
    fn members(
        &mut self,
        name: &str,
        (of_nodes, generate): (bool, bool),
        line: &str,
    ) -> Result<(), FileError> {
        let found = match generate {
            true => self.range(of_nodes, line)?,
            false => self.listed(name, of_nodes, line)?,
        };
        let groups = match of_nodes {
            true => &mut self.mesh.node_groups,
            false => &mut self.mesh.groups,
        };
        add(groups, name, found);
        Ok(())
    }

    /// Nodes or elements of a range; numbers in it may be missing, and there are no more than the file has.
    fn range(&self, of_nodes: bool, line: &str) -> Result<Vec<u32>, FileError> {
        let range = words(line).map(|word| self.number(word));
        let range = range.collect::<Result<Vec<u64>, _>>()?;
        let (first, last, step) = match range[..] {
            [first, last] => (first, last, 1),
            [first, last, step] if step > 0 => (first, last, step),
            _ => return Err(self.damaged("a range has a first, a last and a step".to_owned())),
        };
        let place = if of_nodes { &self.node } else { &self.element };
        let mut numbers: Vec<(u64, u32)> = (place.iter())
            .filter(|(n, _)| (first..=last).contains(*n) && (*n - first).is_multiple_of(step))
            .map(|(number, place)| (*number, *place))
            .collect();
        numbers.sort_unstable();
        Ok(numbers.into_iter().map(|(_, place)| place).collect())
    }

    /// Nodes or elements by their numbers and those of other sets.
    fn listed(&self, name: &str, of_nodes: bool, line: &str) -> Result<Vec<u32>, FileError> {
        let (what, place, groups) = match of_nodes {
            true => ("node", &self.node, &self.mesh.node_groups),
            false => ("element", &self.element, &self.mesh.groups),
        };
        let absent = |what: &str, word: &str| {
            self.damaged(format!("{what} {word} of set {name} is not there"))
        };
        let mut found = Vec::new();
        for word in words(line) {
            match word.parse::<u64>() {
                Ok(number) => {
                    let own = place.get(&number).copied();
                    found.push(own.ok_or_else(|| absent(what, word))?);
                }
                Err(_) => {
                    let others = members(groups, word);
                    found.extend(others.ok_or_else(|| absent("set", word))?);
                }
            }
        }
        Ok(found)
    }

    fn kind(&self, name: &str) -> Result<ElementKind, FileError> {
        let refused = |remedy| self.unsupported("the type of elements", name.to_owned(), remedy);
        kind_of(name).map_err(refused)
    }

    fn number(&self, word: &str) -> Result<u64, FileError> {
        word.parse()
            .map_err(|_| self.damaged(format!("`{word}` is no number of a node or element")))
    }

    fn damaged(&self, reason: String) -> FileError {
        FileError::Damaged {
            path: self.path.to_path_buf(),
            place: Some(Place::Line(self.line)),
            reason,
        }
    }

    fn unsupported(&self, what: &'static str, found: String, remedy: &'static str) -> FileError {
        FileError::Unsupported {
            path: self.path.to_path_buf(),
            what,
            found: format!("{found} (line {})", self.line),
            remedy,
        }
    }
}

/// The keyword of a line, and its options with their values; `GENERATE` has none.
fn options(line: &str) -> (String, Vec<(String, &str)>) {
    let mut parts = line.split(',').map(str::trim);
    let word = parts.next().unwrap_or("").to_uppercase();
    let given = parts
        .map(|part| part.split_once('=').unwrap_or((part, "")))
        .map(|(key, value)| (key.trim().to_uppercase(), value.trim().trim_matches('"')));
    (word, given.collect())
}

fn words(line: &str) -> impl Iterator<Item = &str> {
    line.split(',')
        .map(str::trim)
        .filter(|word| !word.is_empty())
}

/// Members of a group; names are without case, as in Abaqus.
fn members<'a>(groups: &'a [Group<u32>], name: &str) -> Option<&'a [u32]> {
    let found = groups
        .iter()
        .find(|group| group.name.eq_ignore_ascii_case(name));
    found.map(|group| &group.members[..])
}

fn add(groups: &mut Vec<Group<u32>>, name: &str, members: impl IntoIterator<Item = u32>) {
    match groups
        .iter_mut()
        .find(|group| group.name.eq_ignore_ascii_case(name))
    {
        Some(group) => group.members.extend(members),
        None => groups.push(Group {
            name: name.to_owned(),
            members: members.into_iter().collect(),
        }),
    }
}
