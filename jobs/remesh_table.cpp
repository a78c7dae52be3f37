#include "jobs/remesh_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <utility>
#include <vector>

#include "io/file/atomic_file.h"
#include "io/file/read_file.h"
#include "io/item_id.h"
#include "io/json/json_reader.h"
#include "io/json_writer.h"
#include "io/run_error.h"
#include "io/table/csv_writer.h"

namespace meander {

namespace fs = std::filesystem;

namespace {

// The columns of numbers: their names, and where a record has them.
struct Column {
  const char* name;
  std::int64_t (*get)(const RemeshRecord&);
  void (*set)(RemeshRecord&, std::int64_t);
};
template <auto Member>
constexpr Column of_mesh(const char* name) {
  return {name, [](const RemeshRecord& r) { return static_cast<std::int64_t>(r.mesh.*Member); },
          [](RemeshRecord& r, std::int64_t value) {
            using Value = std::remove_reference_t<decltype(r.mesh.*Member)>;
            r.mesh.*Member = static_cast<Value>(value);
          }};
}
constexpr Column columns[] = {
    {"samples", [](const RemeshRecord& r) { return std::int64_t{r.samples}; },
     [](RemeshRecord& r, std::int64_t value) { r.samples = static_cast<std::uint32_t>(value); }},
    of_mesh<&RemeshReport::vertices>("vertices"),
    of_mesh<&RemeshReport::line_vertices>("line_vertices"),
    of_mesh<&RemeshReport::kept_vertices>("kept_vertices"),
    of_mesh<&RemeshReport::faces>("faces"),
    of_mesh<&RemeshReport::components>("components"),
    of_mesh<&RemeshReport::boundary_loops>("boundary_loops"),
    of_mesh<&RemeshReport::euler>("euler"),
    of_mesh<&RemeshReport::dropped_components>("dropped_components"),
    of_mesh<&RemeshReport::coincident_samples>("coincident_samples")};

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
  for (const Column& column : columns) column.set(record, json.integer(column.name).value_or(0));
  for (const Fraction& fraction : fractions) {
    const auto found = json.members().find(fraction.name);
    if (found != json.members().end()) fraction.in(record) = std::strtod(found->second.c_str(), nullptr);
  }
  return record;
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
  for (auto [id, record] : table.records) {
    json.key(id);
    json.begin_object();
    json.member("status", name_of(record.status));
    json.member("message", record.message);
    json.member("file", record.file);
    if (record.status == Status::ok)
      for (const Column& column : columns) json.member(column.name, column.get(record));
    for (const Fraction& fraction : fractions) json.member(fraction.name, fraction.in(record));
    json.end_object();
  }
  json.end_object();
  json.end_object();
  return json.text() + "\n";
}

std::string csv_of(const RemeshTable& table) {
  Table csv;
  for (const char* name : {"id", "status", "message", "file"}) csv.columns.push_back({name});
  for (const Column& column : columns) csv.columns.push_back({column.name});
  for (const Fraction& fraction : fractions) csv.columns.push_back({fraction.name});
  for (auto [id, record] : table.records) {
    std::vector<TableCell>& row = csv.rows.emplace_back();
    row = {id, std::string(name_of(record.status)), record.message, record.file};
    const bool ok = record.status == Status::ok;
    for (const Column& column : columns) row.push_back(ok ? TableCell(column.get(record)) : TableCell());
    for (const Fraction& fraction : fractions) row.emplace_back(fraction.in(record));
  }
  return csv_text(csv);
}

}  // namespace

std::string remesh_message(const RemeshReport& report) {
  std::string message;
  const auto add = [&](const std::string& sentence) { message += (message.empty() ? "" : "; ") + sentence; };
  if (report.dropped_components > 0)
    add(
        fmt::format("{} of {} components have no sample and were dropped, {:.2g} % of the area: more samples "
                    "keep them",
                    report.dropped_components, report.dropped_components + report.components,
                    100 * report.dropped_share));
  if (report.kept_vertices > 0)
    add(fmt::format("{} vertices of the surface stayed: none of the removals tried keeps the topology",
                    report.kept_vertices));
  if (report.coincident_samples > 0)
    add(fmt::format("{} samples are at places where others are", report.coincident_samples));
  return message;
}

fs::path remesh_json_path(const fs::path& folder) { return folder / "remesh.json"; }
fs::path remesh_csv_path(const fs::path& folder) { return folder / "remesh.csv"; }

std::optional<RemeshTable> read_remesh_table(const fs::path& folder) {
  const std::string source = remesh_json_path(folder).string();
  const std::optional<std::string> text = content_if_exists(source);
  if (!text) return std::nullopt;
  const JsonObject json(*text, source);
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

void write_remesh_table(const fs::path& folder, const RemeshTable& table) {
  replace_file(remesh_csv_path(folder), csv_of(table));
  replace_file(remesh_json_path(folder), json_of(table));
}

}  // namespace meander
