// What the server counts, read as strictly as Prometheus does.
#include "host/apps/serve/session/metrics.hpp"

#include <gtest/gtest.h>

#include "tests/serve/metrics_text.hpp"

namespace simuli::serve {
namespace {

using test::MetricsText;

TEST(Metrics, CountsCallsByStatus) {
  Metrics metrics;
  metrics.count_call("render_rgb", "OK", 0.03, 1000);
  metrics.count_call("render_rgb", "OK", 0.001, 500);
  metrics.count_call("render_rgb", "NOT_FOUND", 70.0, 0);
  metrics.count_call("get_version", "OK", 0.0, 8);
  const MetricsText text(metrics.text());
  EXPECT_EQ(text.value("simuli_requests_total{call=\"render_rgb\",status=\"OK\"}"), 2.0);
  EXPECT_EQ(text.value("simuli_requests_total{call=\"render_rgb\",status=\"NOT_FOUND\"}"), 1.0);
  EXPECT_EQ(text.value("simuli_reply_bytes_total{call=\"render_rgb\"}"), 1500.0);
  EXPECT_EQ(text.value("simuli_reply_bytes_total{call=\"get_version\"}"), 8.0);
  // A bound counts what is as long as it.
  EXPECT_EQ(text.value("simuli_request_seconds_bucket{call=\"render_rgb\",le=\"0.001\"}"), 1.0);
  EXPECT_EQ(text.value("simuli_request_seconds_bucket{call=\"render_rgb\",le=\"0.02\"}"), 1.0);
  EXPECT_EQ(text.value("simuli_request_seconds_bucket{call=\"render_rgb\",le=\"0.05\"}"), 2.0);
  EXPECT_EQ(text.value("simuli_request_seconds_bucket{call=\"render_rgb\",le=\"60\"}"), 2.0);
  EXPECT_EQ(text.value("simuli_request_seconds_bucket{call=\"render_rgb\",le=\"+Inf\"}"), 3.0);
  EXPECT_NEAR(text.value("simuli_request_seconds_sum{call=\"render_rgb\"}"), 70.031, 1e-9);
  EXPECT_EQ(text.value("simuli_request_seconds_count{call=\"render_rgb\"}"), 3.0);
}

TEST(Metrics, HasWhatNobodyAskedForYet) {
  const std::vector<Gauge> gauges{{"simuli_device_queue", "Requests that wait for the device.", 3.0}};
  const MetricsText text(Metrics().text(gauges));
  EXPECT_EQ(text.value("simuli_scene_hits_total"), 0.0);
  EXPECT_EQ(text.value("simuli_stage_seconds_count{stage=\"encoding\"}"), 0.0);
  EXPECT_EQ(text.value("simuli_device_queue"), 3.0);
}

/// The reader itself.
TEST(Metrics, TextsThatAreNoneAreRefused) {
  const std::string head = "# HELP a_total x\n# TYPE a_total counter\n";
  EXPECT_EQ(MetricsText(head + "a_total 1\n").value("a_total"), 1.0);
  const auto refused = [](const std::string& text) {
    EXPECT_THROW(MetricsText{text}, std::runtime_error) << text;
  };
  refused(head + "a_total 1");               // no end
  refused(head + "a_total one\n");           // no number
  refused(head + "a_total -1\n");            // counters never fall below 0
  refused(head + "a_total 1\na_total 1\n");  // twice
  refused(head + "b_total 1\n");             // without its type
  refused(head + "a_total{x=\"1\" 1\n");     // half a label
  refused(head + "a_total{x=1} 1\n");        // a label's value without quotes
  refused(head + head + "a_total 1\n");      // described twice
  refused("# TYPE h histogram\nh_bucket{le=\"1\"} 2\nh_bucket{le=\"+Inf\"} 1\nh_sum 1\nh_count 1\n");
  refused("# TYPE h histogram\nh_bucket{le=\"1\"} 1\nh_sum 1\nh_count 1\n");  // no +Inf
  refused("# TYPE h histogram\nh_bucket{le=\"+Inf\"} 1\nh_sum 1\nh_count 2\n");
}

}  // namespace
}  // namespace simuli::serve
