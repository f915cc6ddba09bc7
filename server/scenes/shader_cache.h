// Where the driver caches compiled shaders, and how it compiles.
//
// All renderer processes share one folder, so that each program is compiled once. A software driver
// can omit its optimisation passes: Mesa's llvmpipe then compiles in half the time and draws a
// third slower, with the same bytes. This shortens the first frame after an empty cache.
#pragma once

#include <filesystem>
#include <string>

namespace clerestory {

// Call before OpenGL is used and before processes are started; children inherit it. `folder`: empty
// for the user's own cache, "none" for no cache. MESA_SHADER_CACHE_DIR in the environment wins. A
// folder that cannot be written is logged, and compiled shaders are then kept in memory alone.
void useShaderCache(const std::filesystem::path& folder);

// From now on the driver of this process compiles without optimisation. Call before OpenGL is used.
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
