// R1 and R3 of the failure catalogue: every field with values of every wrong type, and every number
// at its limits and just beyond. Fields and limits are read from the schema, so new fields are
// tested automatically.
#include "server/api/frame_json.h"
#include "server/api/sequence_request.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <functional>
#include <map>
#include <set>

namespace clerestory::test {
namespace {

using nlohmann::json;

// A place in the document: puts a value there, and is named by the pointer.
struct Place {
    std::string pointer;
    std::function<json(json)> body = [](json value) { return value; };

    Place field(const std::string& name) const {
        return {pointer + "/" + name, [outer = body, name](json value) {
                    return outer(json{{name, std::move(value)}});
                }};
    }
    // A list of that many equal elements; the error names the first.
    Place element(std::size_t count) const {
        return {pointer + "/0",
                [outer = body, count](json value) { return outer(json(count, std::move(value))); }};
    }
};

bool outOfRange(const Place& place, const json& value) {
    try {
        frameRequestFrom(place.body(value));
    } catch (const RequestError& error) {
        for (const FieldError& e : error.problem().errors) {
            if (e.pointer == place.pointer && e.detail == "is out of range") return true;
        }
    }
    return false;
}

struct Pair {
    json inside, outside;
};

std::vector<Pair> pairsOf(const json& schema) {
    if (schema.at("type") == "integer") {
        const auto least = schema.at("minimum").get<std::int64_t>();
        const auto most = schema.at("maximum").get<std::int64_t>();
        return {{least, least - 1}, {most, most + 1}};
    }
    const double least = schema.at("minimum"), most = schema.at("maximum");
    return {{least, std::nextafter(least, -INFINITY)}, {most, std::nextafter(most, INFINITY)}};
}

// The schema without references; the document has no cycles.
json resolved(json schema, const json& schemas) {
    if (schema.is_object() && schema.contains("$ref")) {
        const std::string path = schema["$ref"];
        return resolved(schemas.at(path.substr(path.rfind('/') + 1)), schemas);
    }
    if (schema.is_structured()) {
        for (json& part : schema) part = resolved(std::move(part), schemas);
    }
    return schema;
}

json frameSchema() {
    const json schemas(frameRequestSchemas());
    return resolved(schemas.at("FrameRequest"), schemas);
}

// The place inside of an object of a tagged union, or `place` itself.
Place inAlternative(const json& schema, const Place& place) {
    const json type = schema.value("/properties/type/const"_json_pointer, json());
    if (type.is_null()) return place;
    return {place.pointer, [outer = place.body, type](json value) {
                if (value.is_object()) value.emplace("type", type);
                return outer(std::move(value));
            }};
}

void walk(const json& schema, const Place& outside, int& pairs) {
    const Place place = inAlternative(schema, outside);
    for (const json& one : schema.value("oneOf", json::array())) walk(one, place, pairs);
    const json properties = schema.value("properties", json::object());
    for (const auto& [name, inner] : properties.items()) walk(inner, place.field(name), pairs);
    if (schema.contains("items")) {
        walk(schema.at("items"), place.element(schema.value("minItems", std::size_t{1})), pairs);
    }
    if (!schema.contains("minimum")) return;
    for (const Pair& pair : pairsOf(schema)) {
        EXPECT_FALSE(outOfRange(place, pair.inside)) << place.pointer << " " << pair.inside;
        EXPECT_TRUE(outOfRange(place, pair.outside)) << place.pointer << " " << pair.outside;
        ++pairs;
    }
    for (const json& never : {json(1e300), json(-1e300)}) {
        EXPECT_TRUE(outOfRange(place, never)) << place.pointer << " " << never;
    }
}

// The union of the types of all branches of the schema.
std::set<std::string> typesOf(const json& schema) {
    std::set<std::string> types;
    for (const json& one : schema.value("oneOf", json::array())) types.merge(typesOf(one));
    if (schema.contains("type")) {
        const std::string type = schema.at("type");
        types.insert(type == "integer" ? "number" : type);
    }
    return types;
}

bool refused(const Place& place, const json& value) {
    try {
        frameRequestFrom(place.body(value));
    } catch (const RequestError& error) {
        for (const FieldError& e : error.problem().errors) {
            if (e.pointer.starts_with(place.pointer) && !e.detail.empty() && !e.allowed.empty()) {
                return true;
            }
        }
    }
    return false;
}

void walkKinds(const json& schema, const Place& place, int& cases) {
    const std::map<std::string, json> values = {
        {"number", 0.5},   {"string", "no such word"}, {"boolean", true},
        {"null", nullptr}, {"array", json::array()},   {"object", json::object()}};
    const std::set<std::string> types = typesOf(schema);
    for (const auto& [type, value] : values) {
        if (types.contains(type)) continue;
        EXPECT_TRUE(refused(place, value)) << place.pointer << " " << value;
        ++cases;
    }
    if (schema.contains("enum")) {
        EXPECT_TRUE(refused(place, "no such word")) << place.pointer;
        ++cases;
    }
    const auto inner = [&](const json& one) {
        const json properties = one.value("properties", json::object());
        for (const auto& [name, property] : properties.items()) {
            walkKinds(property, inAlternative(one, place).field(name), cases);
        }
        if (one.contains("items"))
            walkKinds(one.at("items"), place.element(one.value("minItems", std::size_t{1})), cases);
    };
    inner(schema);
    for (const json& one : schema.value("oneOf", json::array())) inner(one);
}

TEST(Limits, EveryFieldRejectsOtherTypes) {
    int cases = 0;
    walkKinds(frameSchema(), Place{}, cases);
    EXPECT_GT(cases, 300);
    std::cout << cases << " cases\n";
}

TEST(Limits, HoldForEveryNumberInTheSchema) {
    int pairs = 0;
    walk(frameSchema(), Place{}, pairs);
    EXPECT_GT(pairs, 80);
    RecordProperty("pairs", pairs);
    std::cout << pairs << " pairs\n";
}

std::vector<FieldError> errorsOf(const std::string& body) {
    try {
        sequenceFrom(strictJson(body));
    } catch (const RequestError& error) {
        EXPECT_EQ(error.problem().code, ProblemCode::invalidFields);
        return error.problem().errors;
    }
    return {};
}

std::string framesOf(std::size_t count, const std::string& frame) {
    std::string text = "{\"frames\":[" + frame;
    for (std::size_t i = 1; i < count; ++i) text += "," + frame;
    return text;
}

// What follows is not read: a body of 4 MB took 100 MB.
TEST(Limits, ReadingEndsAtTheGreatestNumberOfFrames) {
    const auto errors = errorsOf(framesOf(kMaxSequenceFrames + 1, "{}") + " no JSON");
    ASSERT_EQ(errors.size(), 1u);
    EXPECT_EQ(errors[0].pointer, "/frames");
    EXPECT_TRUE(errorsOf(framesOf(kMaxSequenceFrames, "{}") + "]}").empty());
}

TEST(Limits, ReadingEndsAtTheGreatestNumberOfValues) {
    const std::string matrix = R"({"camera":{"cameraToWorld":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}})";
    EXPECT_TRUE(errorsOf(framesOf(16'000, matrix) + "]}").empty());
    try {
        strictJson(framesOf(90'000, "[0,0,0,0,0]") + " no JSON");
        ADD_FAILURE() << "accepted";
    } catch (const RequestError& error) {
        EXPECT_EQ(error.problem().detail, "The body has more than 500000 values.");
    }
}

// A frame changes the common fields for itself only, and has the default of a part it leaves out.
TEST(Limits, FramesOfASequenceAreCheckedWithTheCommonFields) {
    const auto pointers = [](const char* body) {
        std::vector<std::string> list;
        for (const FieldError& error : errorsOf(body)) list.push_back(error.pointer);
        return list;
    };
    using testing::ElementsAre;
    EXPECT_THAT(pointers(R"({"common":{"width":4096},"frames":[{"height":4096},{}]})"),
                ElementsAre("/frames/0/width"));
    EXPECT_THAT(pointers(R"({"common":{"width":4096,"height":4096},
                             "frames":[{"height":8},{},{"width":8}]})"),
                ElementsAre("/frames/1/width"));
    EXPECT_THAT(pointers(R"({"common":{"output":{"classes":[{"name":"a","pattern":"b"}]}},
                             "channels":{"classId":true},"frames":[{},{"output":{}}]})"),
                ElementsAre("/frames/1/output/classes"));
    EXPECT_THAT(pointers(R"({"common":{"width":0},"frames":[{"time":-1},{"scene":[]},3]})"),
                ElementsAre("/common/width", "/frames/0/time", "/frames/1/scene", "/frames/2"));
    EXPECT_THAT(pointers(R"({"frames":{}})"), ElementsAre("/frames"));
}

// What is answered does not grow with what is wrong.
TEST(Limits, AnswersToManyErrorsAreShort) {
    const auto answerTo = [](const std::string& body) {
        try {
            frameRequestFrom(strictJson(body));
        } catch (const RequestError& error) {
            EXPECT_LE(error.problem().errors.size(), kMaxFieldErrors);
            return problemJson(error.problem(), "1");
        }
        ADD_FAILURE() << "accepted";
        return std::string();
    };
    std::string doubled, unknown = "{\"width\": 8";
    for (int i = 0; i < 14; ++i)
        doubled += "{\"" + std::string(64, static_cast<char>('a' + i)) + "\":";
    doubled += "{\"a\": 0";
    for (int i = 0; i < 9'000; ++i) {
        doubled += ",\"a\":0";
        unknown += ",\"k" + std::to_string(i) + "\":0";
    }
    EXPECT_LT(answerTo(doubled + std::string(15, '}')).size(), 100'000u);
    EXPECT_LT(answerTo(unknown + "}").size(), 100'000u);
}

}  // namespace
}  // namespace clerestory::test
