//! Probes: what they read, where, and under which name.

use super::parts::region;
use crate::scenario::{Document, GaugeTable, KeyPath, MeasureName, ProbeTable, ScenarioError};
use rsph_core::measures::MEASURES;
use rsph_core::particles::{Field, shown_columns};
use rsph_core::setup::{Gauge, Mechanics, Probe, Quantity, RemeshTrigger};
use rsph_core::simulation::{OwnReading, own_readings};
use rsph_core::tensor::Vec3;
use std::collections::BTreeSet;

/// All `[[probe]]` entries.
pub fn probes(
    doc: &Document,
    tables: &[ProbeTable],
    (mechanics, gauges): (&Mechanics, &[Gauge]),
    trigger: RemeshTrigger,
) -> Result<Vec<Probe>, ScenarioError> {
    let mut headers = BTreeSet::from(["time".to_owned()]);
    for OwnReading { name: header, quantity, .. } in own_readings(mechanics, gauges, trigger) {
        if !headers.insert(header.clone()) {
            return Err(doc.error(
                &KeyPath::from(if quantity.ends_with("of gauges") { "gauge" } else { "boundary" }),
                format!("probes.csv would have two columns named \"{header}\""),
                "give every boundary and every gauge a name of its own",
            ));
        }
    }
    let mut probes = Vec::with_capacity(tables.len());
    for (i, table) in tables.iter().enumerate() {
        let path = KeyPath::from("probe").index(i);
        let name = name(doc, &path.key("name"), &table.name)?;
        let quantity = quantity(doc, &path.key("quantity"), &table.quantity)?;
        for header in headers_of(&name, quantity) {
            if !headers.insert(header.clone()) {
                return Err(doc.error(
                    &path.key("name"),
                    format!("probes.csv would have two columns named \"{header}\""),
                    "give every probe a name of its own",
                ));
            }
        }
        let region = region(doc, &path.key("region"), &table.region)?;
        probes.push(Probe { name, quantity, region });
    }
    Ok(probes)
}

/// All `[[gauge]]` entries.
pub fn gauges(doc: &Document, tables: &[GaugeTable]) -> Result<Vec<Gauge>, ScenarioError> {
    let gauge = |(i, table): (usize, &GaugeTable)| {
        let path = KeyPath::from("gauge").index(i);
        let name = name(doc, &path.key("name"), &table.name)?;
        Ok(Gauge { name, from: Vec3::from(table.from), to: Vec3::from(table.to) })
    };
    tables.iter().enumerate().map(gauge).collect()
}

/// A name that may head a column of probes.csv.
pub fn name(doc: &Document, path: &KeyPath, name: &str) -> Result<String, ScenarioError> {
    let plain = |c: char| c.is_alphanumeric() || "_-. ".contains(c);
    if name.trim().is_empty() || name.trim() != name || !name.chars().all(plain) {
        return Err(doc.error(
            path,
            "the name heads a column of probes.csv: letters, digits, `_`, `-`, `.` and inner blanks are allowed, commas are not",
            "for example `name = \"extension\"`",
        ));
    }
    Ok(name.to_owned())
}

/// The measures that `output.fields` asks for, each once.
pub fn measures(doc: &Document, names: &[MeasureName]) -> Result<Vec<Field>, ScenarioError> {
    let mut fields = Vec::with_capacity(names.len());
    for (i, MeasureName(name)) in names.iter().enumerate() {
        let path = KeyPath::from("output.fields").index(i);
        let known: Vec<&str> = MEASURES.iter().map(|field| field.spec().name).collect();
        let Some(field) = Field::from_name(name).filter(|field| MEASURES.contains(field)) else {
            let remedy = match shown_columns().find(|c| c.name == name) {
                Some(_) => format!("remove it: `{name}` is in every frame of a body that has it"),
                None => crate::scenario::suggestion(name, &known).map_or_else(
                    || "for example \"principal_strain\"".into(),
                    |s| format!("did you mean \"{s}\"?"),
                ),
            };
            let problem = format!("no measure of deformation or stress; allowed: {}", known.join(", "));
            return Err(doc.error(&path, problem, remedy));
        };
        if !fields.contains(&field) {
            fields.push(field);
        }
    }
    Ok(fields)
}

fn quantity(doc: &Document, path: &KeyPath, text: &str) -> Result<Quantity, ScenarioError> {
    Quantity::parse(text).ok_or_else(|| {
        let names: Vec<&str> = shown_columns().map(|c| c.name).collect();
        let field = text.split('.').next().unwrap_or_default();
        let remedy = match shown_columns().find(|c| c.name == field) {
            Some(c) if c.components == 1 => format!("`{field}` is a single number: write \"{field}\""),
            Some(c) => {
                format!("`{field}` has the components {}", c.suffixes.join(", "))
            }
            None => crate::scenario::suggestion(field, &names).map_or_else(
                || "for example \"displacement.z\"".into(),
                |s| format!("did you mean \"{}\"?", text.replacen(field, s, 1)),
            ),
        };
        let problem =
            format!("unknown quantity; allowed: {}, or a component such as .x or .xy", names.join(", "));
        doc.error(path, problem, remedy)
    })
}

fn headers_of(name: &str, quantity: Quantity) -> Vec<String> {
    let suffixes = quantity.field.spec().suffixes;
    if quantity.component.is_some() || suffixes.is_empty() {
        return vec![name.to_owned()];
    }
    suffixes.iter().map(|s| format!("{name}_{s}")).collect()
}
