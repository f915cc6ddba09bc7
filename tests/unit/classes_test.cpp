// Patterns of names, and the classes that they give to instances.
#include "scene/classes.h"
#include "scene/name_pattern.h"
#include "plan_scenes.h"

#include <gmock/gmock.h>

#include <random>

namespace clerestory::test {
namespace {

// The definition, by recursion.
bool matchesByDefinition(std::string_view pattern, std::string_view name) {
    if (pattern.empty()) return name.empty();
    if (pattern[0] == '*') {
        return matchesByDefinition(pattern.substr(1), name) ||
               (!name.empty() && matchesByDefinition(pattern, name.substr(1)));
    }
    return !name.empty() && pattern[0] == name[0] &&
           matchesByDefinition(pattern.substr(1), name.substr(1));
}

TEST(Classes, AStarMatchesAnyText) {
    EXPECT_TRUE(matchesName("car*", "car 7"));
    EXPECT_TRUE(matchesName("car*", "car"));
    EXPECT_FALSE(matchesName("car*", "a car"));
    EXPECT_TRUE(matchesName("*", ""));
    EXPECT_TRUE(matchesName("", ""));
    EXPECT_FALSE(matchesName("", "car"));
    EXPECT_FALSE(matchesName("Car", "car"));
    EXPECT_FALSE(matchesName("car.", "cars")) << "only * is special";

    std::mt19937 random(1);
    const auto text = [&](std::string_view letters, std::size_t most) {
        std::string s;
        for (std::size_t n = random() % (most + 1); s.size() < n;) {
            s += letters[random() % letters.size()];
        }
        return s;
    };
    std::size_t found = 0;
    for (int i = 0; i < 20'000; ++i) {
        const std::string pattern = text("ab**", 7), name = text("ab", 8);
        const bool wanted = matchesByDefinition(pattern, name);
        ASSERT_EQ(matchesName(pattern, name), wanted) << pattern << " " << name;
        found += wanted ? 1 : 0;
    }
    EXPECT_GT(found, 1000u);
}

TEST(Classes, ManyStarsTakeAtMostTheProductOfBothLengths) {
    std::string pattern;
    for (int i = 0; i < 127; ++i) pattern += "*a";
    EXPECT_FALSE(matchesName(pattern + "*b", std::string(10'000, 'a')));
}

// garage > (car > wheel, tree)
Scene garage() {
    Scene scene;
    scene.materials.emplace_back();
    const Index mesh = addBoxMesh(scene, "box", 0);
    const auto add = [&](const char* name, Index parent) {
        scene.nodes.push_back({name, parent, glm::dmat4(1.0)});
        return static_cast<Index>(scene.nodes.size() - 1);
    };
    const Index root = add("garage", kNone), car = add("car 1", root), wheel = add("wheel", car);
    for (const Index node : {root, car, wheel, add("tree", root)}) {
        addInstance(scene, node, mesh);
    }
    return scene;
}

TEST(Classes, TheFirstPatternThatMatchesTheNodeOrAnAncestorWins) {
    using testing::ElementsAre;
    const Scene scene = garage();
    EXPECT_THAT(classesOf(scene, {{"car", "car*"}}), ElementsAre(0, 1, 1, 0));
    EXPECT_THAT(classesOf(scene, {{"wheel", "wh*"}, {"car", "car*"}, {"all", "garage"}}),
                ElementsAre(3, 2, 1, 3));
    EXPECT_THAT(classesOf(scene, {{"car", "car*"}, {"wheel", "wh*"}}), ElementsAre(0, 1, 1, 0));
    EXPECT_THAT(classesOf(scene, {{"a", "tree"}, {"b", "wheel"}, {"a", "car 1"}}),
                ElementsAre(0, 1, 2, 1))
        << "one name, one class";
    EXPECT_THAT(classesOf(scene, {}), ElementsAre(0, 0, 0, 0));
}

TEST(Classes, PatternsThatMatchNothingAreNamed) {
    const std::vector<ClassPattern> classes = {{"car", "car*"}, {"boat", "ship"}, {"", "x*y"}};
    const auto errors = problems(garage(), classes);
    ASSERT_EQ(errors.size(), 2u);
    EXPECT_EQ(errors[0].pointer, "/output/classes/1/pattern");
    EXPECT_EQ(errors[1].pointer, "/output/classes/2/pattern");
}

}  // namespace
}  // namespace clerestory::test
