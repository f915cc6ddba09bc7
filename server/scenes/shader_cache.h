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
// for the user's own cache, "none" for no cache. The environment variable MESA_SHADER_CACHE_DIR has
// precedence, and with NVIDIA's driver __GL_SHADER_DISK_CACHE_PATH. A folder that cannot be written
// is logged, and compiled shaders are then kept in memory only.
void useShaderCache(const std::filesystem::path& folder);

// Whether what the driver compiles is found again, by this process and others.
bool keepsShaders();

// From now on the driver of this process compiles without optimisation. Call before OpenGL is used.
void compileFast();
// The same for a child, as a variable of its environment.
inline constexpr const char* kCompileFastVariable = "GALLIVM_PERF=nopt";
// Whether this process compiles without optimisation.
bool compilesFast();

// Whether setCompiled() was called with this text before, by the same build with the same setting
// of compilesFast(). The marks are files in the cache's folder. `clerestory serve` uses the mark of
// its first scene.
bool compiledBefore(const std::string& what);
void setCompiled(const std::string& what);

}  // namespace clerestory
