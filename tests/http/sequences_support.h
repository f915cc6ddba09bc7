// Requests and answers of sequences.
#pragma once

#include "tests/support/test_server.h"

#include <gtest/gtest.h>

#include <string>
#include <utility>
#include <vector>

namespace clerestory::test {

using Files = std::vector<std::pair<std::string, std::string>>;  // name, content
Files filesOfTar(const std::string& tar);
// Fails the test if there is none of the name.
std::string fileOf(const Files& files, const std::string& name);

// A sequence of six-walls, 64x48, with the camera at x = 0, 0.4 ... metres; `more` is merged into
// it.
nlohmann::json orbit(int frames, const nlohmann::json& more = nlohmann::json::object());

}  // namespace clerestory::test
