// Tables as text (RFC 4180), record by record.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace meander {

struct CsvRecord {
  std::uint64_t line = 0;  // where it begins, from 1
  std::vector<std::string> fields;
  bool is_blank() const { return fields.size() == 1 && fields[0].empty(); }
  bool is_comment() const { return fields[0].starts_with('#'); }
};

// Quoted fields may hold commas, line ends and doubled quotation marks. Blanks around other fields and a
// byte-order mark are ignored.
class CsvText {
 public:
  // source: what messages begin with, an option and the file.
  CsvText(std::string text, std::string source);

  // Throws UsageError for a quotation mark that is not closed, or that text follows.
  std::optional<CsvRecord> next();
  // Throws UsageError: "SOURCE line N: WHAT".
  [[noreturn]] void fail(std::uint64_t line, const std::string& what) const;

 private:
  bool take(char c);
  std::string take_field();
  std::string take_quoted();

  std::string text_, source_;
  std::size_t at_ = 0;
  std::uint64_t line_ = 1;
};

}  // namespace meander
