// Calls and goals whose message types are known from the registry only.

#include <google/protobuf/descriptor.h>
#include <google/protobuf/descriptor.pb.h>
#include <google/protobuf/dynamic_message.h>

#include "msgs/actions.pb.h"
#include "prehend/graph/introspection.h"
#include "tests/graph/test_graph.h"

namespace prehend::graph {
namespace {

namespace pb = google::protobuf;

class RawClients : public GraphTest {
 protected:
  // A message of a type that the registry knows, without its generated code.
  std::unique_ptr<pb::Message> make(const std::string& type) {
    Introspection look(endpoint);
    Schema schema;
    EXPECT_TRUE(eventually([&] {
      try {
        schema = look.schema(type);
        return true;
      } catch (const std::runtime_error&) {
        return false;
      }
    })) << type;
    pb::FileDescriptorSet files;
    EXPECT_TRUE(files.ParseFromString(schema.descriptor_set));
    for (const auto& file : files.file()) {
      if (!pool_.FindFileByName(file.name())) pool_.BuildFile(file);
    }
    return std::unique_ptr<pb::Message>(
        factory_.GetPrototype(pool_.FindMessageTypeByName(type))->New());
  }

  pb::DescriptorPool pool_;
  pb::DynamicMessageFactory factory_{&pool_};
};

TEST_F(RawClients, RegistryKnowsTheTypesOfServicesActionsAndSubscribers) {
  Node node(options("node"));
  const auto service = node.serve<msgs::SpawnRequest, msgs::SpawnResponse>(
      "/s", [](const msgs::SpawnRequest&) { return msgs::SpawnResponse(); });
  const auto action =
      node.serve_action<msgs::MoveGripperGoal, msgs::MoveGripperFeedback, msgs::MoveGripperResult>(
          "/a", [](const auto&, auto&) { return msgs::MoveGripperResult(); });
  const auto subscription =
      node.subscribe<msgs::GripperCommand>("/t", QoS::queue(1), [](const auto&) {});
  for (const char* type : {"SpawnRequest", "SpawnResponse", "MoveGripperGoal",
                           "MoveGripperFeedback", "MoveGripperResult", "GripperCommand"}) {
    EXPECT_TRUE(make(std::string("prehend.msgs.") + type));
  }
}

TEST_F(RawClients, CallsAServiceWithDynamicMessages) {
  Node server(options("server"));
  const auto service = server.serve<msgs::Clock, msgs::Clock>("/s", [](const msgs::Clock& request) {
    if (request.time() < 0) throw std::runtime_error("negative");
    return clock_message(request.time() + 1);
  });
  server.spin_in_background();
  Node node(options("client"));
  const auto request = make("prehend.msgs.Clock"), response = make("prehend.msgs.Clock");
  const auto client = node.raw_client("/s", *request->GetDescriptor(), *response->GetDescriptor());
  std::string error;
  ASSERT_TRUE(request->ParseFromString(clock_message(41).SerializeAsString()));
  EXPECT_EQ(client.call(*request, *response, 5s, error), Status::kOk) << error;
  EXPECT_EQ(response->SerializeAsString(), clock_message(42).SerializeAsString());
  ASSERT_TRUE(request->ParseFromString(clock_message(-1).SerializeAsString()));
  EXPECT_EQ(client.call(*request, *response, 5s, error), Status::kFailed);
  EXPECT_NE(error.find("negative"), std::string::npos) << error;
}

TEST_F(RawClients, SendsAGoalAndSomebodyElseCancelsIt) {
  Node server(options("server"));
  const auto action = server.serve_action<msgs::Clock, msgs::Clock, msgs::Clock>(
      "/a", [](const msgs::Clock& goal, ActionContext<msgs::Clock>& context) {
        context.feedback(clock_message(7));
        if (goal.time() > 0) context.sleep_for(std::chrono::nanoseconds(goal.time()));
        return clock_message(8);
      });
  server.spin_in_background();
  Node node(options("client"));
  node.spin_in_background();
  const auto goal = make("prehend.msgs.Clock"), result = make("prehend.msgs.Clock");
  const auto* type = goal->GetDescriptor();
  const auto client = node.raw_action_client("/a", *type, *type, *type);
  std::atomic<int> feedback = 0;
  const auto count = [&](const std::string& bytes) {
    feedback += bytes == clock_message(7).SerializeAsString() ? 1 : 100;
  };
  bool has_result = false;
  std::string error;
  EXPECT_EQ(client.send(*goal, count).wait(*result, has_result, 5s, error), Status::kOk) << error;
  EXPECT_EQ(feedback, 1);
  EXPECT_EQ(result->SerializeAsString(), clock_message(8).SerializeAsString());

  Introspection look(endpoint);
  EXPECT_THROW(look.cancel_action("/a"), std::runtime_error) << "nothing runs";
  EXPECT_THROW(look.cancel_action("/b"), std::runtime_error) << "no such action";
  ASSERT_TRUE(goal->ParseFromString(clock_message(3600'000'000'000).SerializeAsString()));
  const auto handle = client.send(*goal, count);
  ASSERT_TRUE(eventually([&] { return feedback == 2; }));
  look.cancel_action("/a");
  EXPECT_EQ(handle.wait(*result, has_result, 5s, error), Status::kCancelled);
  EXPECT_TRUE(has_result);
}

}  // namespace
}  // namespace prehend::graph
