// SPDX-License-Identifier: Apache-2.0
// The node of ROS 2: PointCloud2 in, labeled PointCloud2, detections and markers out. client/ros/README.md describes
// it.
#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <rclcpp/rclcpp.hpp>
#include <sensor_msgs/msg/point_cloud2.hpp>
#include <string>
#include <utility>
#include <visualization_msgs/msg/marker_array.hpp>

#include "client/ros/core/cloud_segmenter.hpp"
#include "client/ros/core/node_options.hpp"
#include "client/ros/core/ros_messages.hpp"

namespace segserve::ros {
namespace {

using sensor_msgs::msg::PointCloud2;
using visualization_msgs::msg::MarkerArray;

constexpr int kWarningPeriod = 5000;  // ms

class Node : public rclcpp::Node {
 public:
  Node() : rclcpp::Node("segserve") {}

  absl::Status start() {
    const auto options = parse_parameters(read_parameters());
    if (!options.ok()) return options.status();
    labeled_ = create_publisher<PointCloud2>("~/labeled", rclcpp::QoS(1));
    detections_ = create_publisher<MarkerArray>("~/detections", rclcpp::QoS(1));
    markers_ = create_publisher<MarkerArray>("~/markers", rclcpp::QoS(1));
    auto segmenter = CloudSegmenter::start(
        *options, {.on_segmented = [this](const SegmentedCloud& cloud) { publish(cloud); },
                   .on_warning =
                       [this](const std::string& text) {
                         RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), kWarningPeriod, "%s", text.c_str());
                       }});
    if (!segmenter.ok()) return segmenter.status();
    segmenter_ = *std::move(segmenter);
    clouds_ = create_subscription<PointCloud2>("points", rclcpp::SensorDataQoS().keep_last(1),
                                               [this](PointCloud2::ConstSharedPtr message) { receive(message); });
    RCLCPP_INFO(get_logger(), "clouds of %s are segmented by %s", clouds_->get_topic_name(),
                options->client.address.c_str());
    return absl::OkStatus();
  }

 private:
  /// All parameters as text. Each of them may be set to text, a number or a truth value.
  std::map<std::string, std::string> read_parameters() {
    rcl_interfaces::msg::ParameterDescriptor descriptor;
    descriptor.dynamic_typing = true;
    descriptor.read_only = true;
    std::map<std::string, std::string> values;
    for (const ParameterInfo& info : parameter_table()) {
      descriptor.description = info.unit.empty() ? info.description : info.description + " [" + info.unit + "]";
      const auto value = declare_parameter(info.name, rclcpp::ParameterValue(info.default_value), descriptor);
      values[info.name] =
          value.get_type() == rclcpp::PARAMETER_STRING ? value.get<std::string>() : rclcpp::to_string(value);
    }
    return values;
  }

  /// Nobody is asked while nobody listens.
  bool is_heard() const {
    return labeled_->get_subscription_count() + detections_->get_subscription_count() +
               markers_->get_subscription_count() >
           0;
  }

  void receive(const PointCloud2::ConstSharedPtr& message) {
    if (!is_heard()) return;
    const absl::Status added = segmenter_->add(incoming_cloud(message));
    if (added.ok()) return;
    RCLCPP_WARN_THROTTLE(get_logger(), *get_clock(), kWarningPeriod, "a cloud was refused: %s",
                         std::string(added.message()).c_str());
  }

  void publish(const SegmentedCloud& cloud) {
    if (labeled_->get_subscription_count() > 0) labeled_->publish(labeled_message<PointCloud2>(cloud));
    if (detections_->get_subscription_count() > 0) detections_->publish(detection_message<MarkerArray>(cloud));
    if (markers_->get_subscription_count() > 0) markers_->publish(marker_message<MarkerArray>(cloud));
  }

  rclcpp::Publisher<PointCloud2>::SharedPtr labeled_;
  rclcpp::Publisher<MarkerArray>::SharedPtr detections_, markers_;
  std::unique_ptr<CloudSegmenter> segmenter_;  // its thread publishes
  rclcpp::Subscription<PointCloud2>::SharedPtr clouds_;
};

}  // namespace
}  // namespace segserve::ros

int main(int argc, char** argv) {
  try {
    rclcpp::init(argc, argv);
    const auto node = std::make_shared<segserve::ros::Node>();
    if (const absl::Status started = node->start(); !started.ok()) {
      RCLCPP_FATAL(node->get_logger(), "%s", std::string(started.message()).c_str());
      return 2;
    }
    rclcpp::spin(node);
    rclcpp::shutdown();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "segserve_node: %s\n", error.what());
    return 1;
  }
}
