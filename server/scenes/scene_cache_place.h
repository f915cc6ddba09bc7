// What the command line asks to be kept from one start to the next: imported scenes, and beside
// them the curves of budgets.
#pragma once

#include "server/cli/config.h"
#include "server/jobs/curve_store.h"

namespace clerestory {

// The user's own place for caches, by the XDG Base Directory Specification; empty where there is
// none.
std::filesystem::path userCache();

// Null where there is none.
std::shared_ptr<SceneCache> sceneCacheOf(const CacheOptions& options);
std::shared_ptr<CurveStore> curveStoreOf(const CacheOptions& options);

}  // namespace clerestory
