#include "kernels/sample/column_makers.h"

#include <utility>

#include "kernels/sample/sample_attributes.h"
#include "kernels/sample/sample_colors.h"

namespace meander {

MadeColumn make_colors(const ColumnSource& source, Row& row) {
  SampleColors made = sample_colors(source.file, row.samples, source.cancel);
  row.samples.rgb = std::move(made.rgb);
  row.report.color_source = made.source;
  row.report.color_fills = made.fills;
  return {};
}

MadeColumn make_coordinates(const ColumnSource& source, Row& row) {
  SampleValues made = sample_coordinates(source.file, row.samples, source.cancel);
  row.samples.texcoord = std::move(made.values);
  return {made.lacks_some, made.is_missing};
}

}  // namespace meander
