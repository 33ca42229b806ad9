//! `modelDescription.xml`, and `buildDescription.xml` of FMI 3.0.

use super::variables::{Enumeration, NONE, Role, Value, Variable, decimal};
use super::{Part, Version, escaped};
use crate::Name;

/// What is described.
pub(super) struct Model<'a> {
    pub(super) part: &'a Part,
    pub(super) name: &'a Name,
    pub(super) guid: &'a str,
    pub(super) compiled: &'a [String],
}

/// Duration that a host proposes by itself [s].
const SHOWN_S: f64 = 5.0;

impl Version {
    /// As the interface writes it.
    pub fn number(self) -> &'static str {
        match self {
            Version::Two => "2.0",
            Version::Three => "3.0",
        }
    }
}

impl Model<'_> {
    pub(super) fn description(&self, version: Version) -> String {
        let (variables, enumerations) = (&self.part.variables, self.part.enumerations);
        let parts = match version {
            Version::Two => [
                self.co_simulation_2(),
                units(variables),
                types(enumerations, simple_type_2),
                categories(),
                self.experiment(),
                listed("ModelVariables", variables.iter().map(variable_2)),
                structure_2(self.part),
            ],
            Version::Three => [
                self.co_simulation_3(),
                units(variables),
                types(enumerations, type_3),
                categories(),
                self.experiment(),
                listed("ModelVariables", std::iter::once(TIME_3.to_owned()).chain(variables.iter().map(variable_3))),
                structure_3(self.part),
            ],
        };
        format!("{}\n{}\n</fmiModelDescription>\n", self.opening(version), parts.join("\n"))
    }

    fn opening(&self, version: Version) -> String {
        let (name, guid, number) = (self.name.as_str(), self.guid, version.number());
        let identity = match version {
            Version::Two => "guid",
            Version::Three => "instantiationToken",
        };
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <fmiModelDescription fmiVersion=\"{number}\" modelName=\"{name}\" {identity}=\"{guid}\"\n  \
             description=\"{}\"\n  generationTool=\"flexbeam {}\" variableNamingConvention=\"structured\">",
            escaped(&self.part.description),
            env!("CARGO_PKG_VERSION")
        )
    }

    fn co_simulation_2(&self) -> String {
        let files = self.compiled.iter().map(|file| format!("<File name=\"{file}\"/>"));
        format!(
            "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"false\"\n    \
             canNotUseMemoryManagementFunctions=\"true\" canGetAndSetFMUstate=\"true\" canSerializeFMUstate=\"true\"\n    \
             canBeInstantiatedOnlyOncePerProcess=\"false\">\n    <SourceFiles>{}</SourceFiles>\n  </CoSimulation>",
            self.name.as_str(),
            files.collect::<String>()
        )
    }

    fn co_simulation_3(&self) -> String {
        format!(
            "  <CoSimulation modelIdentifier=\"{}\" canHandleVariableCommunicationStepSize=\"false\"\n    \
             fixedInternalStepSize=\"{}\" canGetAndSetFMUState=\"true\" canSerializeFMUState=\"true\"\n    \
             canBeInstantiatedOnlyOncePerProcess=\"false\"/>",
            self.name.as_str(),
            decimal(self.part.period_s)
        )
    }

    fn experiment(&self) -> String {
        let step = decimal(self.part.period_s);
        format!("  <DefaultExperiment startTime=\"0\" stopTime=\"{SHOWN_S}\" stepSize=\"{step}\"/>")
    }

    /// How FMI 3.0 has the sources compiled.
    pub(super) fn build_description(&self) -> String {
        let files: String = self.compiled.iter().map(|file| format!("      <SourceFile name=\"{file}\"/>\n")).collect();
        format!(
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<fmiBuildDescription fmiVersion=\"3.0\">\n  \
             <BuildConfiguration modelIdentifier=\"{}\">\n    \
             <SourceFileSet language=\"C99\" compilerOptions=\"-ffp-contract=off\">\n{files}    </SourceFileSet>\n  \
             </BuildConfiguration>\n</fmiBuildDescription>\n",
            self.name.as_str()
        )
    }
}

/// The units, with their powers of base units.
const UNITS: [(&str, &str); 5] = [
    ("rad", " rad=\"1\""),
    ("rad/s", " rad=\"1\" s=\"-1\""),
    ("V", " kg=\"1\" m=\"2\" s=\"-3\" A=\"-1\""),
    ("N.m", " kg=\"1\" m=\"2\" s=\"-2\""),
    (NONE, ""),
];

/// Those that a variable has.
fn units(variables: &[Variable]) -> String {
    let unit = |v: &Variable| match v.value {
        Value::Number(unit, _) | Value::NotBelow(unit, ..) => Some(unit),
        Value::Whole(..) | Value::Enumeration(..) => None,
    };
    let used = UNITS.iter().filter(|(name, _)| variables.iter().any(|v| unit(v) == Some(*name)));
    listed("UnitDefinitions", used.map(|(name, base)| format!("<Unit name=\"{name}\"><BaseUnit{base}/></Unit>")))
}

fn types(enumerations: &[Enumeration], each: impl Fn(&Enumeration) -> String) -> String {
    listed("TypeDefinitions", enumerations.iter().map(each))
}

fn items((_, _, items): &Enumeration) -> String {
    let item = |(value, (name, text)): (usize, &(&str, &str))| {
        format!("<Item name=\"{name}\" value=\"{value}\" description=\"{}\"/>", escaped(text))
    };
    items.iter().enumerate().map(item).collect()
}

fn simple_type_2(of: &Enumeration) -> String {
    let (name, text) = (of.0, escaped(of.1));
    format!("<SimpleType name=\"{name}\" description=\"{text}\"><Enumeration>{}</Enumeration></SimpleType>", items(of))
}

fn type_3(of: &Enumeration) -> String {
    let (name, text) = (of.0, escaped(of.1));
    format!("<EnumerationType name=\"{name}\" description=\"{text}\">{}</EnumerationType>", items(of))
}

fn categories() -> String {
    "  <LogCategories><Category name=\"logStatusError\" description=\"What was refused, and why\"/></LogCategories>"
        .to_owned()
}

fn listed(element: &str, lines: impl Iterator<Item = String>) -> String {
    let lines: Vec<String> = lines.map(|line| format!("    {line}")).collect();
    format!("  <{element}>\n{}\n  </{element}>", lines.join("\n"))
}

/// Causality, variability and, where the standard leaves a choice, what the initial value is.
fn role(variable: &Variable) -> &'static str {
    match variable.role {
        Role::Input => "causality=\"input\" variability=\"continuous\"",
        Role::Output => "causality=\"output\" variability=\"discrete\" initial=\"calculated\"",
        Role::Setting => "causality=\"parameter\" variability=\"tunable\" initial=\"exact\"",
        Role::Fixed => "causality=\"parameter\" variability=\"fixed\" initial=\"exact\"",
    }
}

const LARGEST_INTEGER: u64 = i32::MAX as u64;

fn variable_2(variable: &Variable) -> String {
    let Variable { reference, name, description, .. } = variable;
    let value = match variable.value {
        Value::Number(unit, start) => {
            format!("<Real unit=\"{unit}\"{}/>", start.map_or(String::new(), |x| start_of(&decimal(x))))
        }
        Value::NotBelow(unit, start, least) => {
            format!("<Real unit=\"{unit}\" min=\"{}\"{}/>", decimal(least), start_of(&decimal(start)))
        }
        // The largest Integer of FMI 2.0 has 31 bits.
        Value::Whole(start, largest) => {
            format!("<Integer min=\"0\" max=\"{}\"{}/>", largest.min(LARGEST_INTEGER), start_of(&start.to_string()))
        }
        Value::Enumeration(of, start) => {
            format!("<Enumeration declaredType=\"{of}\"{}/>", start.map_or(String::new(), |x| start_of(&x.to_string())))
        }
    };
    let (role, description) = (role(variable), escaped(description));
    format!(
        "<ScalarVariable name=\"{name}\" valueReference=\"{reference}\" description=\"{description}\" {role}>{value}</ScalarVariable>"
    )
}

const TIME_3: &str =
    "<Float64 name=\"time\" valueReference=\"0\" causality=\"independent\" variability=\"continuous\"/>";

fn variable_3(variable: &Variable) -> String {
    let Variable { reference, name, description, .. } = variable;
    let (element, value) = match variable.value {
        Value::Number(unit, start) => {
            ("Float64", format!("unit=\"{unit}\"{}", start.map_or(String::new(), |x| start_of(&decimal(x)))))
        }
        Value::NotBelow(unit, start, least) => {
            ("Float64", format!("unit=\"{unit}\" min=\"{}\"{}", decimal(least), start_of(&decimal(start))))
        }
        Value::Whole(start, largest) => {
            ("Int64", format!("min=\"0\" max=\"{largest}\"{}", start_of(&start.to_string())))
        }
        Value::Enumeration(of, start) => (
            "Enumeration",
            format!("declaredType=\"{of}\"{}", start.map_or(String::new(), |x| start_of(&x.to_string()))),
        ),
    };
    let (role, description) = (role(variable), escaped(description));
    format!("<{element} name=\"{name}\" valueReference=\"{reference}\" description=\"{description}\" {role} {value}/>")
}

fn start_of(value: &str) -> String {
    format!(" start=\"{value}\"")
}

/// The outputs follow no input at the same instant: a host finds no algebraic loop.
fn structure_2(part: &Part) -> String {
    let list = |name: &str, made_of: &dyn Fn(&Variable) -> String| {
        let unknown = |v: &Variable| format!("<Unknown index=\"{}\" dependencies=\"{}\"/>", v.reference, made_of(v));
        format!("<{name}>{}</{name}>", outputs(part).map(unknown).collect::<String>())
    };
    let lists = [list("Outputs", &|_| String::new()), list("InitialUnknowns", &|v| made_of(part, v))];
    listed("ModelStructure", lists.into_iter())
}

/// Likewise.
fn structure_3(part: &Part) -> String {
    let unknown = |element: &str, v: &Variable, made_of: &str| {
        format!("<{element} valueReference=\"{}\" dependencies=\"{made_of}\"/>", v.reference)
    };
    let later = outputs(part).map(|v| unknown("Output", v, ""));
    let initial = outputs(part).map(|v| unknown("InitialUnknown", v, &made_of(part, v)));
    listed("ModelStructure", later.chain(initial))
}

fn outputs(part: &Part) -> impl Iterator<Item = &Variable> {
    part.variables.iter().filter(|v| v.role == Role::Output)
}

/// References of the parameters of which an output is made before the first step.
fn made_of(part: &Part, output: &Variable) -> String {
    let names = part.made_of.iter().find(|(name, _)| *name == output.name).map_or(&[][..], |(_, names)| names);
    let references =
        part.variables.iter().filter(|v| names.contains(&v.name.as_str())).map(|v| v.reference.to_string());
    references.collect::<Vec<_>>().join(" ")
}
