//! VTK's XML format of unstructured grids, `.vtu`: the moved nodes, and numbers of the elements, for ParaView and others.
//!
//! Numbers are appended as raw little-endian bytes (VTK File Formats, "XML File Formats").

use std::io::Write;
use std::path::Path;

use relievo_core::{Result, file};

use crate::simulation::{ElementState, Simulation};

/// VTK's number of a hexahedron.
const HEXAHEDRON: u8 = 12;

impl Simulation {
    /// Writes the present state as a `.vtu` file: displacements, velocities and contact pressures of nodes; stress,
    /// Green–Lagrange strain, von Mises stress, principal stresses and strains, volume, fibre stretch and main material of
    /// elements. Lists of another length than the model has nodes or elements are left out.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn write_vtu(&self, path: &Path, elements: &[ElementState], pressures: &[f32]) -> Result<()> {
        let mut data = Appended::default();
        let state = self.state();
        let rows = |rows: &[[f32; 4]]| rows.iter().flat_map(|row| [row[0], row[1], row[2]]).collect::<Vec<f32>>();
        let mut points = String::new();
        points += &data.floats("displacement", 3, &rows(&state.displacements));
        points += &data.floats("velocity", 3, &rows(&state.velocities));
        if pressures.len() == self.model().nodes.len() {
            points += &data.floats("contact_pressure", 1, pressures);
        }
        let mut cells = String::new();
        if elements.len() == self.model().elements.len() {
            let numbers = |of: fn(&ElementState) -> f32| elements.iter().map(of).collect::<Vec<f32>>();
            let tensors =
                |of: fn(&ElementState) -> [f32; 6]| elements.iter().flat_map(move |element| in_vtk(of(element)));
            cells += &data.floats("stress", 6, &tensors(|element| element.stress).collect::<Vec<f32>>());
            cells += &data.floats("strain", 6, &tensors(|element| element.strain).collect::<Vec<f32>>());
            cells += &data.floats("von_mises", 1, &numbers(|element| element.von_mises));
            let principal = |of: fn(&ElementState) -> [f32; 3]| elements.iter().flat_map(of).collect::<Vec<f32>>();
            cells += &data.floats("principal_stress", 3, &principal(|element| element.principal));
            cells += &data.floats("principal_strain", 3, &principal(|element| element.principal_strain));
            cells += &data.floats("volume", 1, &numbers(|element| element.volume));
            cells += &data.floats("fibre_stretch", 1, &numbers(|element| element.fibre_stretch));
        }
        cells += &data.numbers("material", &self.model().main_materials());
        let positions = data.floats("positions", 3, self.positions().as_flattened());
        let corners = data.numbers("connectivity", self.model().elements.as_flattened());
        let count = self.model().elements.len();
        let ends: Vec<u32> = (1..=count as u32).map(|element| 8 * element).collect();
        let offsets = data.numbers("offsets", &ends);
        let types = data.add("types", "UInt8", 1, &vec![HEXAHEDRON; count]);
        let head = format!(
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" \
             header_type=\"UInt64\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{count}\">\n\
             <PointData>\n{points}</PointData>\n<CellData>\n{cells}</CellData>\n<Points>\n{positions}</Points>\n\
             <Cells>\n{corners}{offsets}{types}</Cells>\n</Piece>\n</UnstructuredGrid>\n<AppendedData encoding=\"raw\">\n_",
            self.model().nodes.len()
        );
        file::store(path, |out| {
            out.write_all(head.as_bytes())?;
            out.write_all(&data.bytes)?;
            out.write_all(b"\n</AppendedData>\n</VTKFile>\n")
        })
    }
}

/// The components of a symmetric tensor in VTK's order, xx, yy, zz, xy, yz, xz, from xx, yy, zz, yz, zx, xy.
fn in_vtk([xx, yy, zz, yz, zx, xy]: [f32; 6]) -> [f32; 6] {
    [xx, yy, zz, xy, yz, zx]
}

/// Bytes at the end of the file, each array with its length first.
#[derive(Default)]
struct Appended {
    bytes: Vec<u8>,
}

impl Appended {
    fn add(&mut self, name: &str, kind: &str, width: u32, bytes: &[u8]) -> String {
        let offset = self.bytes.len();
        self.bytes.extend((bytes.len() as u64).to_le_bytes());
        self.bytes.extend(bytes);
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{width}\" format=\"appended\" offset=\"{offset}\"/>\n"
        )
    }

    fn floats(&mut self, name: &str, width: u32, numbers: &[f32]) -> String {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.add(name, "Float32", width, &bytes)
    }

    fn numbers(&mut self, name: &str, numbers: &[u32]) -> String {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_le_bytes()).collect();
        self.add(name, "UInt32", 1, &bytes)
    }
}
