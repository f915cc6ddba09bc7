// The cache of imported scenes that the command line asks for.
#pragma once

#include "server/config.h"

namespace clerestory {

// Null where there is none.
std::shared_ptr<SceneCache> sceneCacheOf(const CacheOptions& options);

}  // namespace clerestory
