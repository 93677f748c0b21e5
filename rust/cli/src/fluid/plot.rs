//! `relievo fluid plot`

mod raster;
mod table;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

use plotters::coord::Shift;
use plotters::prelude::*;
use relievo_core::{Error, Result, file};

use self::raster::Raster;
use self::table::Table;
use crate::Outcome;

/// Pixels of a picture.
const SIZE: (u32, u32) = (1200, 900);
/// Colours that the colour-blind tell apart (Okabe, Ito 2008).
const BLUE: RGBColor = RGBColor(0, 114, 178);
const ORANGE: RGBColor = RGBColor(230, 159, 0);
/// Sizes of texts.
const SMALL: u32 = 27;
const LARGE: u32 = 30;

#[derive(clap::Args)]
pub struct Arguments {
    /// The statistics of a simulation, `statistics.csv`, or its folder of frames.
    statistics: PathBuf,
    /// The picture to write: .png or .svg.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

pub fn run(arguments: &Arguments) -> Outcome {
    let path = match arguments.statistics.is_dir() {
        true => arguments.statistics.join(super::statistics::NAME),
        false => arguments.statistics.clone(),
    };
    let table = Table::read(&path)?;
    let output = &arguments.output;
    let extension = output.extension().map(|extension| extension.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("svg") => {
            let mut text = String::new();
            draw(SVGBackend::with_string(&mut text, SIZE), &table)?;
            file::store(output, |out| out.write_all(text.as_bytes()))?;
        }
        Some("png") => {
            let mut raster = Raster::new(SIZE)?;
            draw(&mut raster, &table)?;
            relievo_render::write_png(output, raster.image())?;
        }
        _ => return Err(unknown(output).into()),
    }
    crate::print(&format!("{} frames\n", table.len()))?;
    Ok(ExitCode::SUCCESS)
}

fn unknown(path: &Path) -> Error {
    Error::unsupported("the format to write is not known")
        .at(path.display().to_string())
        .advise("use the extension .png or .svg")
}

/// Lines of a panel: what they are, their colour and their values.
type Line<'a> = (&'a str, RGBColor, Vec<f64>);

/// Draws all panels.
fn draw<B: DrawingBackend>(backend: B, table: &Table) -> Result<()> {
    let frames = table.column("frame");
    let scaled = |name: &str, factor: f64| table.column(name).iter().map(|value| value * factor).collect::<Vec<_>>();
    let excess: [Line; 2] =
        [("most of a particle", ORANGE, scaled("excess_most", 100.0)), ("mean", BLUE, scaled("excess_mean", 100.0))];
    let energy: [Line; 1] = [("", BLUE, scaled("kinetic_energy", 1.0))];
    let work: [Line; 2] = [("corrections", ORANGE, scaled("corrections", 1.0)), ("steps", BLUE, scaled("steps", 1.0))];
    let time: [Line; 1] = [("", BLUE, scaled("duration", 1.0))];
    let area = backend.into_drawing_area();
    let failed =
        |error: DrawingAreaErrorKind<B::ErrorType>| Error::internal(format!("a plot cannot be drawn: {error}"));
    area.fill(&WHITE).map_err(failed)?;
    let panels = area.split_evenly((2, 2));
    let titles = ["Too dense (%)", "Kinetic energy (J)", "Iterations a frame", "Time a frame (s)"];
    let lines: [&[Line]; 4] = [&excess, &energy, &work, &time];
    for ((panel, title), lines) in panels.iter().zip(titles).zip(lines) {
        draw_panel(panel, title, frames, lines).map_err(failed)?;
    }
    area.present().map_err(failed)
}

fn draw_panel<B: DrawingBackend>(
    panel: &DrawingArea<B, Shift>,
    title: &str,
    frames: &[f64],
    lines: &[Line],
) -> std::result::Result<(), DrawingAreaErrorKind<B::ErrorType>> {
    let last = frames.iter().copied().fold(1.0, f64::max);
    let first = frames.iter().copied().fold(last, f64::min);
    let most = lines.iter().flat_map(|(.., values)| values).copied().fold(0.0, f64::max);
    // Above what several lines reach is room for their names.
    let room = if lines.len() > 1 { 1.45 } else { 1.05 };
    let top = if most > 0.0 { room * most } else { 1.0 };
    let mut chart = ChartBuilder::on(panel)
        .margin(16)
        .caption(title, ("sans-serif", LARGE))
        .x_label_area_size(60)
        .y_label_area_size(96)
        .build_cartesian_2d(first..last, 0.0..top)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(RGBColor(220, 220, 220))
        .x_desc("frame")
        .x_labels(8)
        .y_labels(6)
        .label_style(("sans-serif", SMALL))
        .x_label_formatter(&|value| shown(*value, last - first))
        .y_label_formatter(&|value| shown(*value, top))
        .draw()?;
    for (name, color, values) in lines {
        let points = frames.iter().copied().zip(values.iter().copied());
        let series = chart.draw_series(LineSeries::new(points, color.stroke_width(2)))?;
        if !name.is_empty() {
            let color = *color;
            series.label(*name).legend(move |(x, y)| PathElement::new([(x, y), (x + 20, y)], color.stroke_width(3)));
        }
    }
    if lines.len() > 1 {
        chart
            .configure_series_labels()
            .position(SeriesLabelPosition::UpperRight)
            .background_style(WHITE)
            .border_style(RGBColor(220, 220, 220))
            .label_font(("sans-serif", SMALL))
            .draw()?;
    }
    Ok(())
}

/// A number of a scale whose values reach so far.
fn shown(value: f64, reach: f64) -> String {
    match reach {
        _ if value == 0.0 => "0".into(),
        _ if !(1e-4..1e6).contains(&reach) => format!("{value:.1e}"),
        _ => {
            let digits = (2.0 - reach.log10().floor()).clamp(0.0, 6.0) as usize;
            let text = format!("{value:.digits$}");
            if digits == 0 { text } else { text.trim_end_matches('0').trim_end_matches('.').into() }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_the_digits_that_their_scale_needs() {
        let cases =
            [(0.5, 2.0, "0.5"), (150.0, 400.0, "150"), (0.02, 0.05, "0.02"), (2e7, 5e7, "2.0e7"), (0.0, 1e-9, "0")];
        for (value, reach, expected) in cases {
            assert_eq!(shown(value, reach), expected);
        }
    }
}
