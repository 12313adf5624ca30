//! Holds every declaration of `src/ffi.rs` against the headers of the installed PETSc.

#![allow(clippy::unwrap_used)]

use std::collections::BTreeMap;
use std::process::Command;

use quote::ToTokens;
use syn::parse::{Parse, ParseStream};
use syn::{FnArg, ForeignItem, Ident, Item, ReturnType, Token, Type};

/// Set where PETSc and its headers must be there.
const REQUIRED: &str = "PERIFRAC_REQUIRE_PETSC";

/// Types, functions, constants and structures by name, in comparable form.
#[derive(Default)]
struct Declarations {
    aliases: BTreeMap<String, Type>,
    functions: BTreeMap<String, (Vec<Type>, ReturnType)>,
    constants: BTreeMap<String, (String, String)>,
    structures: BTreeMap<String, Vec<(String, Type)>>,
}

impl Declarations {
    /// The text of a type with all aliases replaced.
    fn resolve(&self, declared: &Type) -> String {
        match declared {
            Type::Ptr(pointer) => {
                let access = if pointer.mutability.is_some() {
                    "mut"
                } else {
                    "const"
                };
                format!("*{access} {}", self.resolve(&pointer.elem))
            }
            Type::Path(path) => self.resolve_path(path),
            Type::BareFn(function) => {
                let inputs: Vec<String> = function
                    .inputs
                    .iter()
                    .map(|input| self.resolve(&input.ty))
                    .collect();
                let output = self.resolve_result(&function.output);
                format!("fn({}) -> {output}", inputs.join(", "))
            }
            other => other.to_token_stream().to_string(),
        }
    }

    fn resolve_path(&self, path: &syn::TypePath) -> String {
        let Some(last) = path.path.segments.last() else {
            return String::new();
        };
        let name = last.ident.to_string();
        if let (true, syn::PathArguments::AngleBracketed(inner)) =
            (name == "Option", &last.arguments)
        {
            let Some(syn::GenericArgument::Type(inner)) = inner.args.first() else {
                return name;
            };
            return format!("Option<{}>", self.resolve(inner));
        }
        match (self.aliases.get(&name), name.as_str()) {
            (_, "c_int") => "i32".into(),
            (_, "c_uint") => "u32".into(),
            (_, "c_double") => "f64".into(),
            (Some(alias), _) => self.resolve(alias),
            (None, _) => name,
        }
    }

    fn resolve_result(&self, result: &ReturnType) -> String {
        match result {
            ReturnType::Default => "()".into(),
            ReturnType::Type(_, result) => self.resolve(result),
        }
    }

    fn signature(&self, name: &str) -> Option<String> {
        let (inputs, output) = self.functions.get(name)?;
        let inputs: Vec<String> = inputs.iter().map(|input| self.resolve(input)).collect();
        Some(format!(
            "fn({}) -> {}",
            inputs.join(", "),
            self.resolve_result(output)
        ))
    }

    fn fields(&self, name: &str) -> Option<Vec<String>> {
        let fields = self.structures.get(name)?.iter();
        Some(
            fields
                .map(|(field, kind)| format!("{field}: {}", self.resolve(kind)))
                .collect(),
        )
    }

    fn take(&mut self, item: Item) {
        match item {
            Item::Type(alias) => {
                self.aliases.insert(alias.ident.to_string(), *alias.ty);
            }
            Item::Const(constant) => {
                let value = constant.expr.to_token_stream().to_string().replace(' ', "");
                let kind = constant.ty.to_token_stream().to_string();
                self.constants
                    .insert(constant.ident.to_string(), (kind, value));
            }
            Item::Struct(structure) => {
                let fields = structure.fields.into_iter();
                let named = fields.filter_map(|f| f.ident.map(|name| (name.to_string(), f.ty)));
                self.structures
                    .insert(structure.ident.to_string(), named.collect());
            }
            Item::ForeignMod(block) => {
                for item in block.items {
                    if let ForeignItem::Fn(function) = item {
                        let inputs = function.sig.inputs.into_iter();
                        let types = inputs.filter_map(|input| match input {
                            FnArg::Typed(typed) => Some(*typed.ty),
                            FnArg::Receiver(_) => None,
                        });
                        let name = function.sig.ident.to_string();
                        self.functions
                            .insert(name, (types.collect(), function.sig.output));
                    }
                }
            }
            _ => {}
        }
    }
}

/// `name = target;`, `name: type = value;` and `name: fn(…) -> type;` of the macros.
enum Entry {
    Handle(Ident, Ident),
    Constant(Ident, Ident, syn::Expr),
    Function(Ident, syn::TypeBareFn),
}

impl Parse for Entry {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let name: Ident = input.parse()?;
        let entry = if input.parse::<Option<Token![=]>>()?.is_some() {
            Self::Handle(name, input.parse()?)
        } else {
            input.parse::<Token![:]>()?;
            if input.peek(Token![fn]) {
                Self::Function(name, input.parse()?)
            } else {
                let kind = input.parse()?;
                input.parse::<Token![=]>()?;
                Self::Constant(name, kind, input.parse()?)
            }
        };
        input.parse::<Token![;]>()?;
        Ok(entry)
    }
}

struct Entries(Vec<Entry>);

impl Parse for Entries {
    fn parse(input: ParseStream<'_>) -> syn::Result<Self> {
        let mut entries = Vec::new();
        while !input.is_empty() {
            entries.push(input.parse()?);
        }
        Ok(Self(entries))
    }
}

/// What `src/ffi.rs` declares.
fn ours() -> Declarations {
    let source = syn::parse_file(include_str!("../src/ffi.rs")).unwrap();
    let mut ours = Declarations::default();
    for item in source.items {
        let Item::Macro(invocation) = item else {
            ours.take(item);
            continue;
        };
        if invocation.ident.is_some() {
            continue;
        }
        for entry in invocation.mac.parse_body::<Entries>().unwrap().0 {
            match entry {
                Entry::Handle(name, target) => {
                    ours.aliases
                        .insert(name.to_string(), syn::parse_quote!(*mut #target));
                }
                Entry::Constant(name, kind, value) => {
                    let value = value.to_token_stream().to_string().replace(' ', "");
                    ours.constants
                        .insert(name.to_string(), (kind.to_string(), value));
                }
                Entry::Function(name, function) => {
                    let inputs = function.inputs.into_iter().map(|input| input.ty).collect();
                    ours.functions
                        .insert(name.to_string(), (inputs, function.output));
                }
            }
        }
    }
    ours
}

/// Flags of the compiler for the installed headers.
fn flags() -> Result<Vec<String>, String> {
    let query = |package: &str| -> Result<Vec<String>, String> {
        let output = Command::new("pkg-config")
            .args(["--cflags", package])
            .output();
        let output = output.map_err(|error| format!("pkg-config: {error}"))?;
        if !output.status.success() {
            return Err(format!("pkg-config does not know {package}"));
        }
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        Ok(text.split_whitespace().map(Into::into).collect())
    };
    let mut flags = query("PETSc")?;
    // Other MPIs than Open MPI are among the flags of PETSc.
    flags.extend(query("ompi-c").unwrap_or_default());
    Ok(flags)
}

/// What the headers declare under these names.
fn theirs(ours: &Declarations) -> Result<Declarations, String> {
    let flags = flags()?;
    let generate = || {
        let mut builder = bindgen::Builder::default()
            .header_contents(
                "petsc_all.h",
                "#include <petscksp.h>\n#include <petscsf.h>\n",
            )
            .clang_args(flags)
            .formatter(bindgen::Formatter::None)
            .layout_tests(false)
            .generate_comments(false);
        for name in ours.functions.keys() {
            builder = builder.allowlist_function(name);
        }
        for name in ours.aliases.keys().chain(ours.structures.keys()) {
            builder = builder.allowlist_type(name);
        }
        builder.allowlist_var("PETSC_COMM_WORLD").generate()
    };
    // Without libclang the generator panics.
    let generated = std::panic::catch_unwind(std::panic::AssertUnwindSafe(generate));
    let generated = generated.map_err(|_| "libclang was not found".to_string())?;
    let text = generated.map_err(|error| error.to_string())?.to_string();
    let mut theirs = Declarations::default();
    let file = syn::parse_file(&text).map_err(|error| error.to_string())?;
    file.items.into_iter().for_each(|item| theirs.take(item));
    Ok(theirs)
}

#[test]
fn every_declaration_is_that_of_the_headers() {
    let ours = ours();
    assert!(ours.functions.len() > 60 && ours.constants.len() > 25);
    let theirs = match theirs(&ours) {
        Ok(theirs) => theirs,
        Err(reason) => {
            assert!(
                std::env::var_os(REQUIRED).is_none(),
                "{REQUIRED} is set, but {reason}"
            );
            eprintln!("skipped: {reason}");
            return;
        }
    };
    for name in ours.functions.keys() {
        assert_eq!(ours.signature(name), theirs.signature(name), "{name}");
    }
    for (name, (kind, value)) in &ours.constants {
        if name == "PETSC_DETERMINE" {
            continue;
        }
        let found = theirs.constants.get(&format!("{kind}_{name}"));
        assert_eq!(found, Some(&(kind.clone(), value.clone())), "{name}");
    }
    for (name, alias) in &ours.aliases {
        if name == "PetscErrorHandler" {
            continue;
        }
        let found = theirs.aliases.get(name).map(|alias| theirs.resolve(alias));
        assert_eq!(Some(ours.resolve(alias)), found, "{name}");
    }
    assert_eq!(ours.fields("MatInfo"), theirs.fields("MatInfo"));
}
