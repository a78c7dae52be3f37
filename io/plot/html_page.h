// A self-contained page of figures.
#pragma once

#include <string>
#include <vector>

#include "io/table/table.h"

namespace meander {

struct PageImage {
  std::string file{};     // relative to the page, `/` between folders, UTF-8
  std::string text{};     // its description, for readers who cannot see it
  std::string caption{};  // below it; empty: none
  std::string svg{};      // an SVG in the page instead of a file
};

// A paragraph with a label such as "Measured" or "Claim".
struct PageParagraph {
  std::string label{};  // set bold before the text; empty: none
  std::string text{};
};

struct PageTable {
  std::string caption{};
  Table table{};
  bool plain = false;  // its cells hold names of users, in which ^{...} and _{...} are not markup
};

struct PageFigure {
  std::string heading{};
  std::vector<PageImage> images{};  // side by side if there is room
  std::vector<PageParagraph> paragraphs{};
  std::vector<PageTable> tables{};
  std::vector<std::string> data{};  // relative paths of data files, linked by their names
};

struct FigurePage {
  std::string title{};
  std::vector<PageParagraph> introduction{};
  std::vector<PageFigure> figures{};
  std::string footer{};  // command line, version, time taken; empty: none
};

// HTML that is also well-formed XML, in UTF-8: a list of contents if there are several figures, style inside,
// light or dark as the reader's system, one column on small screens, no scripts; it loads only the named
// images. All texts are escaped and file names percent-encoded. Throws std::invalid_argument for a file name
// that is absolute or has a scheme (`:` before the first `/`), and what check_table throws.
std::string html_page(const FigurePage& page);

}  // namespace meander
