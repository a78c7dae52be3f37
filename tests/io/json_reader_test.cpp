#include "io/json/json_reader.h"

#include <limits>
#include <string>
#include <vector>

#include "io/json_writer.h"
#include "io/run_error.h"
#include "support/catch.h"

using namespace meander;

namespace {

std::string refusal(const std::string& text) {
  try {
    const JsonObject object(text, "a.json");
  } catch (const RunError& error) {
    CHECK(error.kind() == RunError::Kind::unusable);
    return error.what();
  }
  return {};
}

}  // namespace

TEST_CASE("JsonObject: values are returned exactly as written") {
  const std::vector<std::pair<std::string, std::string>> values = {{"a", "1"},
                                                                   {"b", "-0"},
                                                                   {"c", "1e+300"},
                                                                   {"d", R"("with \" and , and }")"},
                                                                   {"e", R"([1,{"f":2},[]])"},
                                                                   {"g", "true"},
                                                                   {"h", "null"},
                                                                   {"i", "{}"},
                                                                   {"j", "-1.50"},
                                                                   {"k", "\"\""},
                                                                   {"l", R"({ "m" : [ 1 , 2 ] })"}};
  for (const std::string blank : {"", " ", "\n\t"}) {
    std::string text = blank + "{" + blank;
    for (const auto& [name, value] : values)
      text += (name == "a" ? "\"" : "," + blank + "\"") + name + "\"" + blank + ":" + blank + value + blank;
    const JsonObject object(text + "}" + blank, "a.json");
    REQUIRE(object.members().size() == values.size());
    for (const auto& [name, value] : values) CHECK(object.members().at(name) == value);
  }
  CHECK(JsonObject("{}", "a.json").members().empty());
  CHECK(JsonObject(R"({"a":1,"a":2})", "a.json").members().at("a") == "2");
}

TEST_CASE("JsonObject: typed access is empty for a missing member and names file and member on an error") {
  const JsonObject object(
      R"({"text":"caf\u00e9 \" \\ \n","n":-7,"big":9223372036854775807,"over":9223372036854775808,"half":0.5})",
      "a.json");
  CHECK(object.text("text") == "caf\xc3\xa9 \" \\ \n");
  CHECK(object.integer("n") == -7);
  CHECK(object.integer("big") == INT64_MAX);
  CHECK_FALSE(object.text("absent"));
  CHECK_FALSE(object.integer("absent"));
  CHECK_THROWS_WITH(object.text("n"), "a.json: \"n\" is not a text");
  for (const char* name : {"text", "over", "half"})
    CHECK_THROWS_WITH(object.integer(name),
                      "a.json: \"" + std::string(name) + "\" is not a whole number of 64 bits");
}

TEST_CASE("JsonObject: anything but one object is refused with the name of the file") {
  for (const std::string text :
       {"", " ", "[]", "1", "\"a\"", "null", "{", "{\"a\"}", "{\"a\":}", "{\"a\":1,}", "{\"a\":1}}",
        "{\"a\":1} x", "{a:1}", "{\"a\":nan}", "{\"a\":\"b}"}) {
    INFO(text);
    CHECK(refusal(text).starts_with("a.json: not a JSON object"));
  }
  CHECK(refusal("{\"a\":") == "a.json: not a JSON object (wrong at byte 5 of 5)");
  CHECK(refusal("{\"a\":1e400}") == "a.json: not a JSON object (a number is too large)");
  CHECK(JsonObject("\xef\xbb\xbf{\"a\":1}", "a.json").members().at("a") == "1");
  std::string deep(100000, '[');
  CHECK_FALSE(refusal("{\"a\":" + deep).empty());
}

TEST_CASE("JsonObject: reads what JsonWriter writes") {
  JsonWriter json;
  json.begin_object();
  json.member("control", std::string("\x01\x1f\t"));
  json.member("broken", std::string("\xff"));
  json.member("number", 0.1);
  json.member("infinite", std::numeric_limits<double>::infinity());
  json.end_object();
  const JsonObject object(json.text(), "a.json");
  CHECK(object.text("control") == "\x01\x1f\t");
  CHECK(object.text("broken") == "\xef\xbf\xbd");
  CHECK(object.members().at("number") == "0.1");
  CHECK(object.members().at("infinite") == "null");
}
