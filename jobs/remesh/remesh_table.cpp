#include "jobs/remesh/remesh_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "io/item_id.h"
#include "io/json/json_reader.h"
#include "io/json_writer.h"
#include "io/run_error.h"
#include "io/table/table.h"
#include "jobs/cli/units.h"

namespace meander {

namespace {

// The column of whole numbers in front of those of the mesh (remesh_counts).
constexpr const char* samples_column = "samples";

struct Fraction {
  const char* name;
  double& (*in)(RemeshRecord&);
};
constexpr Fraction fractions[] = {
    {"dropped_share", [](RemeshRecord& r) -> double& { return r.mesh.dropped_share; }},
    {"largest_shift", [](RemeshRecord& r) -> double& { return r.mesh.largest_shift; }},
    {"seconds", [](RemeshRecord& r) -> double& { return r.seconds; }}};

RemeshRecord record_of(const JsonObject& json, const std::string& source) {
  RemeshRecord record;
  const std::string status = json.text("status").value_or("");
  const auto at = std::find(status_names.begin(), status_names.end(), status);
  if (at == status_names.end())
    throw RunError(RunError::Kind::unusable, fmt::format("{}: `{}` is no status", source, status));
  record.status = static_cast<Status>(at - status_names.begin());
  record.message = json.text("message").value_or("");
  record.file = json.text("file").value_or("");
  record.lacks = json.text("lacks").value_or("");
  record.samples = static_cast<std::uint32_t>(json.integer(samples_column).value_or(0));
  for (const RemeshCount& count : remesh_counts) count.set(record.mesh, json.integer(count.name).value_or(0));
  for (const Fraction& fraction : fractions) {
    const auto found = json.members().find(fraction.name);
    if (found != json.members().end()) fraction.in(record) = std::strtod(found->second.c_str(), nullptr);
  }
  record.input = {json.integer("input_bytes").value_or(-1), json.integer("input_modified").value_or(-1)};
  return record;
}

void write_record(JsonWriter& json, RemeshRecord record) {
  json.begin_object();
  json.member("status", name_of(record.status));
  json.member("message", record.message);
  json.member("file", record.file);
  if (!record.lacks.empty()) json.member("lacks", record.lacks);
  if (record.status == Status::ok) {
    json.member(samples_column, std::int64_t{record.samples});
    for (const RemeshCount& count : remesh_counts) json.member(count.name, count.of(record.mesh));
  }
  for (const Fraction& fraction : fractions) json.member(fraction.name, fraction.in(record));
  json.member("input_bytes", record.input.bytes);
  json.member("input_modified", record.input.modified);
  json.end_object();
}

}  // namespace

std::string remesh_message(const RemeshReport& report, const std::string& lacks) {
  std::string message;
  const auto add = [&](const std::string& sentence) { message += (message.empty() ? "" : "; ") + sentence; };
  if (report.dropped_components > 0)
    add(fmt::format("{} of {} {} no sample and {} dropped, {:.2g} % of the area: more samples keep them",
                    report.dropped_components,
                    counted(report.dropped_components + report.components, "component", "components"),
                    report.dropped_components == 1 ? "has" : "have",
                    report.dropped_components == 1 ? "was" : "were", 100 * report.dropped_share));
  if (report.kept_vertices > 0)
    add(fmt::format("{} beside the samples stayed: without them the topology changes or triangles cross",
                    counted(report.kept_vertices, "vertex", "vertices")));
  if (report.coincident_samples > 0)
    add(fmt::format("{} at places where others are",
                    counted(report.coincident_samples, "sample is", "samples are")));
  if (report.coarse_lines > 0)
    add(fmt::format(
        "boundaries and creases of {} have longer edges than asked: they would need more than four "
        "times the vertices of all the rest",
        counted(report.coarse_lines, "component", "components")));
  if (report.crossings > 0)
    add(fmt::format("{} of triangles cross that do not in the input: more samples may part them",
                    counted(report.crossings, "pair", "pairs")));
  if (report.partial_search > 0)
    add("nearly all triangles are near each other: not all of them were compared, and those that cross "
        "may not be parted");
  if (!lacks.empty())
    add(fmt::format("the model has no {} at some or all vertices: colors are light gray there, numbers NaN",
                    lacks));
  return message;
}

std::string json_of(const RemeshTable& table) {
  JsonWriter json;
  json.begin_object();
  json.member("made_by", "meander remesh");
  json.member("parameters", table.parameters_json);
  if (!table.root.empty()) json.member("root", escape_id(table.root));
  if (!table.planned.empty()) {
    json.key("planned");
    json.begin_object();
    for (const std::string& file : table.planned) json.member(file, true);
    json.end_object();
  }
  json.key("items");
  json.begin_object();
  for (const auto& [id, record] : table.records) {
    json.key(id);
    write_record(json, record);
  }
  json.end_object();
  json.end_object();
  return json.text() + "\n";
}

std::string csv_of(const RemeshTable& table) {
  Table csv;
  for (const char* name : {"id", "status", "message", "file", "lacks"}) csv.columns.push_back({name});
  csv.columns.push_back({samples_column});
  for (const RemeshCount& count : remesh_counts) csv.columns.push_back({count.name});
  for (const Fraction& fraction : fractions) csv.columns.push_back({fraction.name});
  for (auto [id, record] : table.records) {
    std::vector<TableCell>& row = csv.rows.emplace_back();
    row = {id, std::string(name_of(record.status)), record.message, record.file, record.lacks};
    const bool ok = record.status == Status::ok;
    row.push_back(ok ? TableCell(std::int64_t{record.samples}) : TableCell());
    for (const RemeshCount& count : remesh_counts)
      row.push_back(ok ? TableCell(count.of(record.mesh)) : TableCell());
    for (const Fraction& fraction : fractions) row.emplace_back(fraction.in(record));
  }
  return csv_text(csv);
}

RemeshTable remesh_table_of(const std::string& text, const std::string& source) {
  const JsonObject json(text, source);
  if (json.text("made_by") != "meander remesh")
    throw RunError(
        RunError::Kind::unusable,
        fmt::format("{} is no table of `meander remesh`: move it away, or give another folder", source));
  RemeshTable table;
  table.parameters_json = json.text("parameters").value_or("");
  table.root = unescape_id(json.text("root").value_or(""));
  const auto planned = json.members().find("planned");
  if (planned != json.members().end()) {
    const JsonObject files(planned->second, source);
    for (const auto& [file, is] : files.members()) table.planned.insert(file);
  }
  const auto items = json.members().find("items");
  if (items == json.members().end()) return table;
  const JsonObject records(items->second, source);
  for (const auto& [id, record] : records.members())
    table.records[id] = record_of(JsonObject(record, source), source);
  return table;
}

std::string log_line(const std::string& id) {
  JsonWriter json;
  json.begin_object();
  json.member("begun", id);
  json.end_object();
  return json.text() + "\n";
}

std::string log_line(const std::string& id, const RemeshRecord& record) {
  JsonWriter json;
  json.begin_object();
  json.member("id", id);
  json.key("record");
  write_record(json, record);
  json.end_object();
  return json.text() + "\n";
}

void add_logged(std::string_view log, const std::string& source, RemeshTable& table) {
  for (std::size_t end; (end = log.find('\n')) != std::string_view::npos; log.remove_prefix(end + 1)) {
    try {
      const JsonObject line(log.substr(0, end), source);
      if (const auto begun = line.text("begun")) {
        table.begun.insert(*begun);
      } else {
        const std::string id = line.text("id").value_or("");
        const auto record = line.members().find("record");
        if (id.empty() || record == line.members().end()) return;
        table.records[id] = record_of(JsonObject(record->second, source), source);
        table.begun.erase(id);
      }
    } catch (const RunError&) {
      return;
    }
  }
}

}  // namespace meander
