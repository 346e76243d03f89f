//! A sweep as a table: comma-separated values, and Parquet.

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use parquet::basic::{LogicalType, Repetition, Type as Physical};
use parquet::data_type::{ByteArray, ByteArrayType, DoubleType};
use parquet::file::metadata::KeyValue;
use parquet::file::properties::WriterProperties;
use parquet::file::writer::{SerializedFileWriter, SerializedRowGroupWriter};
use parquet::schema::types::Type;

use super::{Cell, Column, Head, Kind, Row};

/// Writes a table of comma-separated values, a line a point. Columns whose name ends in `_rounded` are numbers of the
/// machine; all others are exact.
///
/// # Errors
/// When it cannot be written.
pub fn write_csv(path: &Path, head: &Head, rows: &[Row]) -> Result<(), String> {
    let wrong = |error: csv::Error| format!("`{}` cannot be written: {error}", path.display());
    let mut writer = csv::Writer::from_path(path).map_err(wrong)?;
    writer.write_record(head.columns.iter().map(|column| column.name.as_str())).map_err(wrong)?;
    for row in rows {
        writer.write_record(row.cells.iter().map(Cell::text)).map_err(wrong)?;
    }
    writer.flush().map_err(|error| format!("`{}` cannot be written: {error}", path.display()))
}

/// Writes the same as Parquet: numbers of the machine as doubles, the rest as text; the hash of the input with it.
///
/// # Errors
/// When it cannot be written.
pub fn write_parquet(path: &Path, head: &Head, rows: &[Row]) -> Result<(), String> {
    let shown = path.display();
    let file = File::create(path).map_err(|error| format!("`{shown}` cannot be written: {error}"))?;
    parquet(file, head, rows).map_err(|error| format!("`{shown}` cannot be written: {error}"))
}

type Failure = parquet::errors::ParquetError;

fn parquet(file: File, head: &Head, rows: &[Row]) -> Result<(), Failure> {
    let fields = head.columns.iter().map(field).collect::<Result<Vec<_>, _>>()?;
    let schema = Type::group_type_builder("sweep").with_fields(fields).build()?;
    let notes = vec![KeyValue::new("pars.input".to_string(), head.input.clone())];
    let properties = WriterProperties::builder().set_key_value_metadata(Some(notes)).build();
    let mut writer = SerializedFileWriter::new(file, Arc::new(schema), Arc::new(properties))?;
    let mut group = writer.next_row_group()?;
    for place in 0..head.columns.len() {
        let cells: Vec<&Cell> = rows.iter().filter_map(|row| row.cells.get(place)).collect();
        column(&mut group, head.columns[place].kind == Kind::Number, &cells)?;
    }
    group.close()?;
    writer.close()?;
    Ok(())
}

fn field(column: &Column) -> Result<Arc<Type>, Failure> {
    let builder = match column.kind {
        Kind::Number => Type::primitive_type_builder(&column.name, Physical::DOUBLE),
        _ => Type::primitive_type_builder(&column.name, Physical::BYTE_ARRAY)
            .with_logical_type(Some(LogicalType::String)),
    };
    Ok(Arc::new(builder.with_repetition(Repetition::OPTIONAL).build()?))
}

/// One column; a cell that is empty, or no number in a column of numbers, is left out.
fn column(group: &mut SerializedRowGroupWriter<'_, File>, numbers: bool, cells: &[&Cell]) -> Result<(), Failure> {
    let Some(mut writer) = group.next_column()? else { return Ok(()) };
    if numbers {
        let values: Vec<Option<f64>> =
            cells.iter().map(|cell| if let Cell::Number(number) = cell { Some(*number) } else { None }).collect();
        let levels: Vec<i16> = values.iter().map(|value| i16::from(value.is_some())).collect();
        let values: Vec<f64> = values.into_iter().flatten().collect();
        writer.typed::<DoubleType>().write_batch(&values, Some(&levels), None)?;
    } else {
        let empty = |cell: &Cell| matches!(cell, Cell::Nothing(()));
        let levels: Vec<i16> = cells.iter().map(|cell| i16::from(!empty(cell))).collect();
        let values: Vec<ByteArray> =
            cells.iter().filter(|cell| !empty(cell)).map(|cell| ByteArray::from(cell.text().into_bytes())).collect();
        writer.typed::<ByteArrayType>().write_batch(&values, Some(&levels), None)?;
    }
    writer.close()
}
