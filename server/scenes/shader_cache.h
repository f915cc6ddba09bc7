// Where the driver keeps compiled shaders, and how it compiles.
//
// All renderer processes share one folder, so that each program is compiled once. A software driver
// can leave out its optimisation passes: Mesa's llvmpipe then compiles in about half the time,
// draws about a third slower, and gives the same bytes. That is right for a frame that somebody
// waits for while nothing is compiled yet.
#pragma once

#include <filesystem>
#include <string>

namespace clerestory {

// Call before OpenGL is used and before processes are started; children inherit it. `folder`: empty
// for the user's own cache, "none" for no cache. MESA_SHADER_CACHE_DIR in the environment wins. A
// folder that cannot be written is logged, and compiled shaders are then kept in memory alone.
void useShaderCache(const std::filesystem::path& folder);

// From now on this process's driver compiles without optimising. Before OpenGL is used.
void compileFast();
// The same for a child, as a variable of its environment.
inline constexpr const char* kCompileFastVariable = "GALLIVM_PERF=nopt";
// Whether this process does.
bool compilesFast();

// Whether this build, compiling as this process does, has compiled something before and kept it:
// marks in the cache's folder, under any text. `clerestory serve` looks for that of its first
// scene.
bool compiledBefore(const std::string& what);
void setCompiled(const std::string& what);

}  // namespace clerestory
