#include "io/plot/html_page.h"

#include <stdexcept>
#include <string>

#include "io/xml_reader.h"
#include "support/catch.h"

using namespace meander;
using meander::test::named;
using meander::test::XmlReader;

namespace {

FigurePage two_figures() {
  FigurePage page;
  page.title = "Figures & <tables>";
  page.introduction = {{"", "Made by 'meander figures'."}};
  page.figures.resize(2);
  page.figures[0].heading = "Figure 4: N^{-1/2} < 1";
  page.figures[0].images = {{"a b#1.svg", "a \"plot\"", "left"}, {"sub/x.png", "spectrum", ""}};
  page.figures[0].paragraphs = {{"Measured", "x < y"}, {"The survey", "claims d_{min}"}};
  PageTable table{"slopes", {}};
  table.table.columns = {{"method"}, {"slope", 3}};
  table.table.rows = {{"<random>", -0.5}, {"none"}};
  page.figures[0].tables = {table};
  page.figures[0].data = {"a.csv", "100%.csv"};
  page.figures[1].heading = "Empty";
  page.footer = "done";
  return page;
}

}  // namespace

TEST_CASE("html_page: is well-formed, with images, texts, tables and links") {
  const auto elements = XmlReader::read(html_page(two_figures()));
  CHECK(elements[0].name == "html");
  CHECK(named(elements, "title").at(0).text == "Figures & <tables>");
  const auto images = named(elements, "img");
  REQUIRE(images.size() == 2);
  CHECK(images[0].attributes.at("src") == "a%20b%231.svg");
  CHECK(images[0].attributes.at("alt") == "a \"plot\"");
  CHECK(images[1].attributes.at("src") == "sub/x.png");
  CHECK(named(elements, "figcaption").size() == 1);
  CHECK(named(elements, "h2").at(0).text == "Figure 4: N-1/2 < 1");
  CHECK(named(elements, "sup").at(0).text == "-1/2");
  CHECK(named(elements, "sub").at(0).text == "min");
  CHECK(named(elements, "strong").at(0).text == "Measured");
  const auto cells = named(elements, "td");
  REQUIRE(cells.size() == 4);
  CHECK(cells[0].text == "<random>");
  CHECK(cells[1].text == "-0.500");
  CHECK(cells[1].attributes.at("class") == "number");
  CHECK(cells[0].attributes.empty());
  CHECK(cells[3].text == "");
  std::vector<std::string> links;
  for (const auto& link : named(elements, "a")) links.push_back(link.attributes.at("href"));
  CHECK(links == std::vector<std::string>{"#figure-1", "#figure-2", "a%20b%231.svg", "sub/x.png", "a.csv",
                                          "100%25.csv"});
  CHECK(named(elements, "section").at(1).attributes.at("id") == "figure-2");
  CHECK(named(elements, "footer").at(0).text == "done");
}

TEST_CASE("html_page: has no scripts and loads nothing from elsewhere") {
  const std::string html = html_page(two_figures());
  CHECK(html.find("<script") == std::string::npos);
  CHECK(html.find("@import") == std::string::npos);
  CHECK(html.find("url(") == std::string::npos);
  CHECK(html.find("prefers-color-scheme: dark") != std::string::npos);
  // The namespace is a name, not an address that is loaded.
  const std::size_t address = html.find("http");
  CHECK(html.substr(address, 28) == "http://www.w3.org/1999/xhtml");
  CHECK(html.find("http", address + 1) == std::string::npos);
}

TEST_CASE("html_page: an empty page is valid") {
  const auto elements = XmlReader::read(html_page({}));
  CHECK(named(elements, "h1").size() == 1);
  CHECK(named(elements, "nav").empty());
  CHECK(named(elements, "footer").empty());
}

TEST_CASE("html_page: file names that are not relative are errors") {
  for (const char* file : {"", "/etc/passwd", "javascript:alert(1)", "https://elsewhere/x.png"}) {
    FigurePage page = two_figures();
    page.figures[0].images[0].file = file;
    CHECK_THROWS_AS(html_page(page), std::invalid_argument);
  }
  FigurePage page = two_figures();
  page.figures[0].data = {"sub/a:b.csv"};  // a colon after a slash is not that of a scheme
  CHECK_NOTHROW(html_page(page));
}
