// SPDX-License-Identifier: Apache-2.0
// The node of ROS 1: PointCloud2 in, labeled PointCloud2, detections and markers out. client/ros/README.md describes
// it.
#include <ros/ros.h>

#include <cstdio>
#include <exception>
#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "client/ros/core/cloud_segmenter.hpp"
#include "client/ros/core/node_options.hpp"
#include "client/ros/core/ros_messages.hpp"
#include "client/ros/ros1/message_types.hpp"

namespace segserve::ros {
namespace {

/// A parameter as text.
std::string text_of(XmlRpc::XmlRpcValue value) {
  switch (value.getType()) {
    case XmlRpc::XmlRpcValue::TypeString:
      return static_cast<std::string&>(value);
    case XmlRpc::XmlRpcValue::TypeBoolean:
      return static_cast<bool&>(value) ? "true" : "false";
    case XmlRpc::XmlRpcValue::TypeInt:
      return std::to_string(static_cast<int&>(value));
    case XmlRpc::XmlRpcValue::TypeDouble: {
      char digits[32];
      std::snprintf(digits, sizeof(digits), "%.17g", static_cast<double&>(value));
      return digits;
    }
    default:
      return "neither text nor a number";
  }
}

/// All parameters in the namespace of the node.
std::map<std::string, std::string> read_parameters(const ::ros::NodeHandle& own) {
  std::vector<std::string> names;
  own.getParamNames(names);
  std::map<std::string, std::string> values;
  const std::string prefix = own.getNamespace() + "/";
  for (const std::string& name : names) {
    XmlRpc::XmlRpcValue value;
    if (name.rfind(prefix, 0) == 0 && own.getParam(name, value)) values[name.substr(prefix.size())] = text_of(value);
  }
  return values;
}

class Node {
 public:
  Node() : own_("~") {}

  absl::Status start() {
    const auto options = parse_parameters(read_parameters(own_));
    if (!options.ok()) return options.status();
    labeled_ = own_.advertise<PointCloud2>("labeled", 1);
    detections_ = own_.advertise<MarkerArray>("detections", 1);
    markers_ = own_.advertise<MarkerArray>("markers", 1);
    auto segmenter = CloudSegmenter::start(
        *options, {.on_segmented = [this](const SegmentedCloud& cloud) { publish(cloud); },
                   .on_warning = [](const std::string& text) { ROS_WARN_THROTTLE(5, "%s", text.c_str()); }});
    if (!segmenter.ok()) return segmenter.status();
    segmenter_ = *std::move(segmenter);
    clouds_ = ::ros::NodeHandle().subscribe<PointCloud2>("points", 1, &Node::receive, this);
    ROS_INFO("clouds of %s are segmented by %s", clouds_.getTopic().c_str(), options->client.address.c_str());
    return absl::OkStatus();
  }

 private:
  /// Nobody is asked while nobody listens.
  bool is_heard() const {
    return labeled_.getNumSubscribers() + detections_.getNumSubscribers() + markers_.getNumSubscribers() > 0;
  }

  void receive(const PointCloud2::ConstPtr& message) {
    if (!is_heard()) return;
    const absl::Status added = segmenter_->add(incoming_cloud(message));
    if (!added.ok()) ROS_WARN_THROTTLE(5, "a cloud was refused: %s", std::string(added.message()).c_str());
  }

  void publish(const SegmentedCloud& cloud) const {
    if (labeled_.getNumSubscribers() > 0) labeled_.publish(labeled_message<PointCloud2>(cloud));
    if (detections_.getNumSubscribers() > 0) detections_.publish(detection_message<MarkerArray>(cloud));
    if (markers_.getNumSubscribers() > 0) markers_.publish(marker_message<MarkerArray>(cloud));
  }

  ::ros::NodeHandle own_;
  ::ros::Publisher labeled_, detections_, markers_;
  std::unique_ptr<CloudSegmenter> segmenter_;  // its thread publishes
  ::ros::Subscriber clouds_;
};

}  // namespace
}  // namespace segserve::ros

int main(int argc, char** argv) {
  try {
    ros::init(argc, argv, "segserve");
    segserve::ros::Node node;
    if (const absl::Status started = node.start(); !started.ok()) {
      ROS_FATAL("%s", std::string(started.message()).c_str());
      return 2;
    }
    ros::spin();
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "segserve_node: %s\n", error.what());
    return 1;
  }
}
