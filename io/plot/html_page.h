// A self-contained page of figures.
#pragma once

#include <string>
#include <vector>

#include "io/table/table.h"

namespace meander {

struct PageImage {
  std::string file{};     // relative to the page, `/` between folders, UTF-8
  std::string text{};     // what one sees in it, for readers who cannot
  std::string caption{};  // below it; empty: none
  std::string svg{};      // instead of a file: what svg_plot and svg_matrix make; it stands in the page
};

// "Measured" and what was, "The survey" and what it claims, ...
struct PageParagraph {
  std::string label{};  // set bold before the text; empty: none
  std::string text{};
};

struct PageTable {
  std::string caption{};
  Table table{};
  bool plain = false;  // names of users: ^{...} and _{...} are no marks in its cells
};

struct PageFigure {
  std::string heading{};
  std::vector<PageImage> images{};  // side by side where there is room
  std::vector<PageParagraph> paragraphs{};
  std::vector<PageTable> tables{};
  std::vector<std::string> data{};  // files behind it, relative; linked by their names
};

struct FigurePage {
  std::string title{};
  std::vector<PageParagraph> introduction{};
  std::vector<PageFigure> figures{};
  std::string footer{};  // command line, version, time taken; empty: none
};

// HTML that is also well-formed XML: UTF-8, contents list when there are several figures, style inside, light
// or dark as the reader's system is set, one column on small screens, no scripts, nothing loaded but the
// images named. All texts are escaped, file names percent-encoded. Throws std::invalid_argument for a file
// name that is absolute or holds a scheme (`:` before the first `/`), and what check_table throws.
std::string html_page(const FigurePage& page);

}  // namespace meander
