// What would grow while it is parsed is refused before; what only looks like it is not.

#include "prehend/text/xml_size.h"

#include <string>

#include <gmock/gmock.h>

#include "prehend/text/input_error.h"

namespace prehend::text {
namespace {

using testing::HasSubstr;

std::string many(const std::string& part, int count) {
  std::string all;
  for (int i = 0; i < count; ++i) all += part;
  return all;
}

std::string refusal_of(const std::string& text) {
  try {
    refuse_xml_bomb(text, "a.xml");
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(XmlSize, CountsElementsAttributesAndDepth) {
  EXPECT_THAT(refusal_of(many("<a/>", 1000001)), HasSubstr("a.xml has more than a million"));
  EXPECT_EQ(refusal_of(many("<a/>", 999999)), "");
  EXPECT_THAT(refusal_of("<a" + many(" b='1'", 1001) + "/>"), HasSubstr("1000 attributes"));
  EXPECT_EQ(refusal_of(many("<a>", 100) + many("</a>", 100)), "");
  EXPECT_THAT(refusal_of(many("<a>", 101)), HasSubstr("nested deeper than 100"));
  EXPECT_EQ(refusal_of(many("<a></a>", 1000) + many("<b c='/'/>", 1000)), "");
}

TEST(XmlSize, TakesNoElementForWhatIsNone) {
  EXPECT_EQ(refusal_of("<!-- " + many("<a>", 200) + " --><b/>"), "");
  EXPECT_EQ(refusal_of("<![CDATA[" + many("<a>", 200) + "]]><b/>"), "");
  EXPECT_EQ(refusal_of("<a b='" + many("<a>", 200) + "'/>"), "");
  EXPECT_EQ(refusal_of("<a b=\"" + many("=", 2000) + "\"/>"), "");
}

// Each hides elements from who takes the quote, or the comment's end, for one.
TEST(XmlSize, IsNotDeceivedAboutWhereElementsBegin) {
  const std::string deep = many("<a>", 101);
  for (const char* before : {"<!x '>", "<?x '>", "<!-->'-->", "<1 '>", "<![CDATA[]]>",
                             "<!DOCTYPE a>", "<? x>", "< '>", "<>'"}) {
    EXPECT_THAT(refusal_of(before + deep), HasSubstr("nested")) << before;
  }
  EXPECT_EQ(refusal_of("<"), "");
  EXPECT_EQ(refusal_of("<a"), "");
  EXPECT_EQ(refusal_of("<a b='"), "");
  EXPECT_EQ(refusal_of(""), "");
}

}  // namespace
}  // namespace prehend::text
