// Metrics of one process and their text in Prometheus's exposition format.
//
//     MetricFamilies all;
//     prometheus::Gauge& depth = all.gauge("clerestory_queue_depth", "Frames waiting or being
//     drawn"); auto& requests = all.counters("clerestory_requests_total", "Requests answered, by
//     route"); requests.Add({{"route", "/v1/frames"}}).Increment(); all.text();
#pragma once

#include <prometheus/counter.h>
#include <prometheus/gauge.h>
#include <prometheus/histogram.h>
#include <prometheus/registry.h>
#include <prometheus/text_serializer.h>

#include <sstream>
#include <string>

namespace clerestory {

class MetricFamilies {
public:
    using Counters = prometheus::Family<prometheus::Counter>;
    using Gauges = prometheus::Family<prometheus::Gauge>;
    using Histograms = prometheus::Family<prometheus::Histogram>;
    using Buckets = prometheus::Histogram::BucketBoundaries;  // upper limits, ascending

    // Families whose metrics have labels; what is returned lives as long as this object.
    Counters& counters(const std::string& name, const std::string& help) {
        return prometheus::BuildCounter().Name(name).Help(help).Register(registry_);
    }
    Gauges& gauges(const std::string& name, const std::string& help) {
        return prometheus::BuildGauge().Name(name).Help(help).Register(registry_);
    }
    Histograms& histograms(const std::string& name, const std::string& help) {
        return prometheus::BuildHistogram().Name(name).Help(help).Register(registry_);
    }
    // Single metrics.
    prometheus::Counter& counter(const std::string& name, const std::string& help) {
        return counters(name, help).Add({});
    }
    prometheus::Gauge& gauge(const std::string& name, const std::string& help) {
        return gauges(name, help).Add({});
    }
    prometheus::Histogram& histogram(const std::string& name, const std::string& help,
                                     const Buckets& buckets) {
        return histograms(name, help).Add({}, buckets);
    }

    std::string text() const {
        std::ostringstream out;
        prometheus::TextSerializer().Serialize(out, registry_.Collect());
        return out.str();
    }

private:
    prometheus::Registry registry_;
};

}  // namespace clerestory
