#include "engine/json/json.h"

#include <gtest/gtest.h>

#include <string>

namespace weft::engine::json_test {
namespace {

using Json = nlohmann::ordered_json;

TEST(Documents, AreDestroyedHoweverDeepTheyAre) {
  std::string text;
  const int depth = 1'000'000;
  for (int i = 0; i < depth; ++i) text += i % 2 == 0 ? "[7,[]," : R"({"a":[1,{"b":null}],"c":)";
  text += "true";
  for (int i = depth - 1; i >= 0; --i) text += i % 2 == 0 ? ",\"text\"]" : "}";
  Json json = Json::parse(text);
  const Json* below = &json;
  for (int i = 0; i < depth; ++i) below = i % 2 == 0 ? &below->at(2) : &below->at("c");
  EXPECT_TRUE(below->get<bool>());
  json = 1;
  EXPECT_EQ(json, 1);
}

}  // namespace
}  // namespace weft::engine::json_test
