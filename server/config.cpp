#include "server/config.h"

namespace clerestory {

LocalBackendOptions localBackendOptions(const Config& config) {
    const UploadOptions& uploads = config.scenes.uploads;
    return {.renderer = config.renderer,
            .queue = {config.queue, config.queueSeconds},
            .scenes = config.scenes,
            .curves = config.curves,
            .limits = {.bodyBytes = config.http.limits.bodyBytes,
                       .sequenceBytes = config.sequenceBytes,
                       .uploadBytes = uploads.folder.empty() ? 0 : uploads.limits.fileBytes,
                       .frameCacheBytes = config.frameCacheBytes,
                       .queue = config.queue,
                       .deadlineSeconds = config.deadlineSeconds},
            .signedLinks = !config.http.access.linkKeyFile.empty()};
}

WorkerBackendOptions workerBackendOptions(const Config& config) {
    return {.workers = config.workers,
            .queue = {config.queue, config.queueSeconds, config.workers.renderers},
            .deadlineSeconds = config.deadlineSeconds,
            .signedLinks = !config.http.access.linkKeyFile.empty()};
}

WorkerOptions workerOptions(const Config& config) {
    return {.threads = config.queue + config.http.threads,
            .hangSeconds = config.hangSeconds,
            .memoryBytes = config.workerMemoryBytes,
            .logLevel = config.logLevel,
            .renderers = config.workers.renderers};
}

}  // namespace clerestory
