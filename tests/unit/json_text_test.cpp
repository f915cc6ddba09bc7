// JSON from outside: values as nlohmann reads them, and the errors with their places.
#include "scene/import/base/json_text.h"

#include "scene/fields.h"

#include <gtest/gtest.h>

namespace clerestory::test {
namespace {

using nlohmann::json;
using Kind = JsonTextError::Kind;

json read(std::string_view text, std::size_t maxDepth = 64) {
    return jsonFrom(text, maxDepth);
}

JsonTextError jsonErrorOf(std::string_view text, std::size_t maxDepth = 64) {
    try {
        read(text, maxDepth);
    } catch (const JsonTextError& error) {
        return error;
    }
    ADD_FAILURE() << "accepted: " << text;
    return {Kind::syntax, 0, ""};
}

TEST(JsonText, ReadsTheValuesThatNlohmannReads) {
    for (const char* text :
         {"null", "true", "-7", "18446744073709551615", "1.5e-3", "\"\\u00e9\\n\"", "[]", "{}",
          R"({"a": [1, [2, {"b": null}], "c"], "d": {"e": {}, "": [[]]}, "f": 0.25})"}) {
        EXPECT_EQ(read(text), json::parse(text)) << text;
    }
}

TEST(JsonText, ErrorsTellThePlace) {
    EXPECT_EQ(jsonErrorOf("").kind, Kind::syntax);
    EXPECT_EQ(jsonErrorOf(R"({"a": 1,})").byte, 9u);
    EXPECT_EQ(jsonErrorOf("[1] 2").kind, Kind::syntax);
    EXPECT_EQ(jsonErrorOf("[[1]]", 1).kind, Kind::depth);
    EXPECT_EQ(read("[[1], {}]", 2).size(), 2u);
    const JsonTextError range = jsonErrorOf(R"({"a~": [0, {"b/": 1e999}]})");
    EXPECT_EQ(range.kind, Kind::numberRange);
    EXPECT_EQ(range.pointer, "/a~0/1/b~1");
}

TEST(JsonText, NamesThatAnObjectHasTwiceAreListedUpToALimit) {
    std::vector<std::string> doubled;
    const json last = jsonFrom(R"({"a": 1, "b": [{"c": 1, "c": 2}], "a": 3})", 8, &doubled);
    EXPECT_EQ(doubled, (std::vector<std::string>{"/b/0/c", "/a"}));
    EXPECT_EQ(last["a"], 3);
    std::string text = "{\"a\": 0";
    for (int i = 0; i < 100'000; ++i) text += ", \"a\": 0";
    doubled.clear();
    jsonFrom(text + ", \"b\": 1}", 8, &doubled);
    EXPECT_EQ(doubled.size(), kMaxFieldErrors);
    EXPECT_EQ(read(text + ", \"b\": 1}"), json::parse(R"({"a": 0, "b": 1})"))
        << "files are read to their end";
}

// A parser that visits the elements before each element takes minutes for these.
TEST(JsonText, LongListsOfObjectsTakeLinearTime) {
    std::string text = "[{}";
    for (int i = 1; i < 400'000; ++i) text += ",{}";
    EXPECT_EQ(read(text + "]").size(), 400'000u);
}

}  // namespace
}  // namespace clerestory::test
