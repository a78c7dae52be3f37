#include "jobs/label_file.h"

#include <algorithm>
#include <optional>
#include <vector>

#include "io/file/file_error.h"
#include "io/file/read_file.h"
#include "jobs/folder_layout.h"
#include "jobs/inputs.h"

namespace meander {

namespace {

struct Record {
  std::uint64_t line = 0;
  std::vector<std::string> fields;
  bool is_blank() const { return fields.size() == 1 && fields[0].empty(); }
};

// The records of a CSV text, one after the other.
class CsvText {
 public:
  CsvText(std::string text, std::string name) : text_(std::move(text)), name_(std::move(name)) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = 3;
  }

  std::optional<Record> next() {
    if (at_ >= text_.size()) return std::nullopt;
    Record record;
    record.line = line_;
    do record.fields.push_back(take_field());
    while (take(','));
    take('\r');
    if (at_ < text_.size() && !take('\n')) fail(record.line, "text behind a closing quotation mark");
    ++line_;
    return record;
  }

  [[noreturn]] void fail(std::uint64_t line, const std::string& what) const {
    throw UsageError("--labels: `" + name_ + "` line " + std::to_string(line) + ": " + what);
  }

 private:
  static bool is_blank(char c) { return c == ' ' || c == '\t'; }
  bool take(char c) {
    if (at_ >= text_.size() || text_[at_] != c) return false;
    ++at_;
    return true;
  }

  std::string take_field() {
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    if (take('"')) return take_quoted();
    std::size_t end = std::min(text_.find_first_of(",\n", at_), text_.size());
    const std::size_t next = end;
    while (end > at_ && (is_blank(text_[end - 1]) || text_[end - 1] == '\r')) --end;
    std::string field = text_.substr(at_, end - at_);
    at_ = next;
    return field;
  }

  std::string take_quoted() {
    const std::uint64_t begin = line_;
    std::string field;
    for (;;) {
      const std::size_t mark = text_.find('"', at_);
      if (mark == std::string::npos) fail(begin, "a quotation mark that is not closed");
      field += text_.substr(at_, mark - at_);
      at_ = mark + 1;
      if (!take('"')) break;
      field += '"';
    }
    line_ += static_cast<std::uint64_t>(std::count(field.begin(), field.end(), '\n'));
    while (at_ < text_.size() && is_blank(text_[at_])) ++at_;
    return field;
  }

  std::string text_, name_;
  std::size_t at_ = 0;
  std::uint64_t line_ = 1;
};

// Which field is what; `most` fields are allowed.
struct Columns {
  std::size_t id = 0, label = 1;
  std::optional<std::size_t> split = 2;
  std::size_t least = 2, most = 3;
};

std::optional<Columns> header_of(const CsvText& text, const Record& record) {
  const auto column = [&](const std::string& name) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < record.fields.size(); ++i) {
      std::string field = record.fields[i];
      std::transform(field.begin(), field.end(), field.begin(),
                     [](char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; });
      if (field == name) return i;
    }
    return std::nullopt;
  };
  const auto id = column("id");
  if (!id) return std::nullopt;
  const auto label = column("class") ? column("class") : column("label");
  if (!label) text.fail(record.line, "the header has no column `class`");
  return Columns{*id, *label, column("split"), record.fields.size(), record.fields.size()};
}

LabelLine read_line(const CsvText& text, const Record& record, const Columns& columns) {
  const std::size_t count = record.fields.size();
  if (count < columns.least || count > columns.most)
    text.fail(record.line,
              std::to_string(count) + " fields, must be " +
                  (columns.least == columns.most ? std::to_string(columns.most)
                                                 : std::string("id, class and optionally split")));
  LabelLine line{record.fields[columns.label], Split::none, record.line};
  if (!columns.split || *columns.split >= count) return line;
  const std::string& word = record.fields[*columns.split];
  line.split = split_of_word(word);
  if (line.split == Split::none && !word.empty() && word != "none")
    text.fail(record.line, "the split `" + word + "` is not train, test or validation");
  return line;
}

}  // namespace

LabelFile read_label_file(const std::filesystem::path& path) {
  std::string bytes;
  try {
    bytes = content_of_file(path);
  } catch (const FileError& error) {
    throw UsageError("--labels: cannot read `" + path.string() + "`: " + error.code().message());
  }
  CsvText text(std::move(bytes), path.string());
  LabelFile labels;
  std::optional<Columns> columns;
  while (const auto record = text.next()) {
    if (record->is_blank()) continue;
    if (!columns) {
      columns = header_of(text, *record);
      if (columns) continue;
      columns.emplace();
    }
    const LabelLine line = read_line(text, *record, *columns);
    const auto [at, is_new] = labels.emplace(record->fields[columns->id], line);
    if (!is_new && (at->second.label != line.label || at->second.split != line.split))
      text.fail(line.line, "another class or split of `" + at->first + "` than in line " +
                               std::to_string(at->second.line));
  }
  return labels;
}

}  // namespace meander
