#include "jobs/inputs/csv_text.h"

#include <algorithm>
#include <utility>

#include "io/utf8.h"
#include "jobs/cli/usage_error.h"

namespace meander {

namespace {

bool is_space(char c) { return c == ' ' || c == '\t'; }

}  // namespace

CsvText::CsvText(std::string text, std::string source) : text_(std::move(text)), source_(std::move(source)) {
  at_ = text_.size() - without_byte_order_mark(text_).size();
}

std::optional<CsvRecord> CsvText::next() {
  if (at_ >= text_.size()) return std::nullopt;
  CsvRecord record;
  record.line = line_;
  do record.fields.push_back(take_field());
  while (take(','));
  take('\r');
  if (at_ < text_.size() && !take('\n')) fail(record.line, "text follows a closing quotation mark");
  ++line_;
  return record;
}

void CsvText::fail(std::uint64_t line, const std::string& what) const {
  throw UsageError(source_ + " line " + std::to_string(line) + ": " + what);
}

bool CsvText::take(char c) {
  if (at_ >= text_.size() || text_[at_] != c) return false;
  ++at_;
  return true;
}

std::string CsvText::take_field() {
  while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  if (take('"')) return take_quoted();
  std::size_t end = std::min(text_.find_first_of(",\n", at_), text_.size());
  const std::size_t next = end;
  while (end > at_ && (is_space(text_[end - 1]) || text_[end - 1] == '\r')) --end;
  std::string field = text_.substr(at_, end - at_);
  at_ = next;
  return field;
}

std::string CsvText::take_quoted() {
  const std::uint64_t begin = line_;
  std::string field;
  for (;;) {
    const std::size_t mark = text_.find('"', at_);
    if (mark == std::string::npos) fail(begin, "a quotation mark is not closed");
    field += text_.substr(at_, mark - at_);
    at_ = mark + 1;
    if (!take('"')) break;
    field += '"';
  }
  line_ += static_cast<std::uint64_t>(std::count(field.begin(), field.end(), '\n'));
  while (at_ < text_.size() && is_space(text_[at_])) ++at_;
  return field;
}

}  // namespace meander
