
#include "io/parameters_text.h"
#include "support/catch.h"

using namespace meander;

TEST_CASE("parameters: every member that differs is named with both values") {
  CHECK(parameter_differences(R"({"a":1,"b":"x,y","c":[1,2]})", R"({"a":1,"b":"x,y","c":[1,2]})").empty());
  CHECK(
      parameter_differences(R"({"order":"curve","seed":1,"z":{"k":1}})",
                            R"({"bins":64,"seed":2,"z":{"k":1}})") ==
      R"(parameter "bins" was not given, now it is 64; parameter "order" was "curve" and is not given now; )"
      R"(parameter "seed" was 1, now it is 2)");
  // The order of the members does not matter.
  CHECK(parameter_differences(R"({"a":1,"b":2})", R"({"b":2,"a":1})").empty());
  CHECK(parameter_differences("old", R"({"a":1})") == R"(the parameters were old, now they are {"a":1})");
}

TEST_CASE("parameters: splitting and joining gives the same text") {
  const std::string text = R"({"a":"with \" and , inside","b":{"c":[1,{"d":2}]},"e":-1.5})";
  const auto members = split_members(text);
  CHECK(members.size() == 3);
  CHECK(members.at("b") == R"({"c":[1,{"d":2}]})");
  CHECK(join_members(members) == text);
  // Names are escaped as texts are.
  for (const char* const odd : {R"({"a\"b":1,"c\\":[]})", R"({"\u0001":"x","":{}})", "{}"}) {
    const auto parts = split_members(odd);
    CHECK(split_members(join_members(parts)) == parts);
  }
  CHECK(join_members(split_members(R"({"c\\":[]})")) == R"({"c\\":[]})");
}
