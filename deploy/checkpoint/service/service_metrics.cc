#include "deploy/checkpoint/service/service_metrics.h"

#include "common/check.h"

namespace sinew::checkpoint {
namespace {

constexpr char kCalls[] = "sinew_store_calls_total";
constexpr char kCallsHelp[] = "Calls by rpc and result.";

}  // namespace

ServiceMetrics::ServiceMetrics(metrics::Registry& registry)
    : received_bytes(registry.AddCounter("sinew_store_received_bytes_total",
                                         "Bytes of blobs taken in.")),
      sent_bytes(registry.AddCounter("sinew_store_sent_bytes_total",
                                     "Bytes of blobs handed out.")),
      upload_bytes(registry.AddGauge("sinew_store_upload_bytes",
                                     "Bytes of uploads in flight.")),
      upload_limit_bytes(
          registry.AddGauge("sinew_store_upload_limit_bytes",
                            "Most bytes of uploads in flight at once.")),
      last_artifact_timestamp_seconds(
          registry.AddGauge("sinew_store_last_artifact_timestamp_seconds",
                            "When an artifact was last registered.")) {
  for (const char* rpc : {"GetBlob", "PutBlob", "PutArtifact", "GetArtifact",
                          "ListArtifacts", "SetAlias", "Retain", "DropBlobs"}) {
    Calls& calls = calls_[rpc];
    calls.ok = &registry.AddCounter(kCalls, kCallsHelp,
                                    {{"rpc", rpc}, {"result", "ok"}});
    calls.failed = &registry.AddCounter(kCalls, kCallsHelp,
                                        {{"rpc", rpc}, {"result", "failed"}});
  }
}

void ServiceMetrics::Count(const std::string& rpc, const absl::Status& status) {
  const auto found = calls_.find(rpc);
  SINEW_CHECK(found != calls_.end()) << rpc;
  (status.ok() ? found->second.ok : found->second.failed)->Increment();
}

}  // namespace sinew::checkpoint
