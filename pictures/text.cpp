#include <volccd/pictures/text.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

namespace volccd {

namespace {

/// Strokes are pairs of digits "xy"; x from 0 to `width`, y from 0 with the base line at 2, capitals to 8, small
/// letters to 6. A stroke that begins with ~ is the round curve with these control points.
struct Glyph {
  char character;
  int width;
  const char* strokes;
};

constexpr Glyph kGlyphs[] = {
    {'A', 4, "022842 1434"},
    {'B', 4, "0802 ~082848452505 ~052545422202"},
    {'C', 4, "~474808024243"},
    {'D', 4, "0802 ~082848422202"},
    {'E', 4, "48080242 0535"},
    {'F', 4, "480802 0535"},
    {'G', 4, "~474808024245 2545"},
    {'H', 4, "0802 4842 0545"},
    {'I', 0, "0802"},
    {'J', 3, "~3834320204"},
    {'K', 4, "0802 4804 1542"},
    {'L', 3, "080232"},
    {'M', 4, "0208244842"},
    {'N', 4, "02084248"},
    {'O', 4, "~0208484202"},
    {'P', 4, "0802 ~082848442404"},
    {'Q', 4, "~0208484202 2442"},
    {'R', 4, "0802 ~082848442404 2442"},
    {'S', 4, "~4748080545420203"},
    {'T', 4, "0848 2822"},
    {'U', 4, "~080502424548"},
    {'V', 4, "082248"},
    {'W', 6, "0822375268"},
    {'X', 4, "0842 4802"},
    {'Y', 4, "082548 2522"},
    {'Z', 4, "08480242"},
    {'a', 3, "~0206363202 3632"},
    {'b', 3, "0802 ~0206363202"},
    {'c', 3, "~353606023233"},
    {'d', 3, "3832 ~0206363202"},
    {'e', 3, "~343606023233 0434"},
    {'f', 2, "~28181512 0626"},
    {'g', 3, "~0206363202 ~3633300001"},
    {'h', 3, "0802 ~0406363432"},
    {'i', 0, "0602 0808"},
    {'j', 1, "~16121000 1818"},
    {'k', 3, "0802 3603 1432"},
    {'l', 0, "0802"},
    {'m', 4, "0602 ~0406262422 ~2426464442"},
    {'n', 3, "0602 ~0406363432"},
    {'o', 3, "~0206363202"},
    {'p', 3, "0600 ~0206363202"},
    {'q', 3, "3630 ~0206363202"},
    {'r', 2, "0602 ~040626"},
    {'s', 3, "~3536060434320203"},
    {'t', 2, "~18131222 0626"},
    {'u', 3, "~060402323436 3632"},
    {'v', 4, "062246"},
    {'w', 4, "0612253246"},
    {'x', 3, "0632 3602"},
    {'y', 4, "0622 4610"},
    {'z', 3, "06360232"},
    {'0', 3, "~0205083835320205"},
    {'1', 3, "072822"},
    {'2', 3, "~0708383502 0232"},
    {'3', 3, "~0708383515 ~1535320203"},
    {'4', 3, "22280434"},
    {'5', 3, "380805 ~0536320203"},
    {'6', 3, "~3738080504 ~0205353202"},
    {'7', 3, "083812"},
    {'8', 3, "~0508383505 ~0205353202"},
    {'9', 3, "~3635320203 ~0508383505"},
    {'.', 0, "0202"},
    {',', 1, "1201"},
    {':', 0, "0202 0505"},
    {';', 1, "1201 1515"},
    {'-', 3, "0434"},
    {'+', 4, "0545 2327"},
    {'=', 3, "0434 0636"},
    {'(', 1, "~19070311"},
    {')', 1, "~09171301"},
    {'[', 1, "19090111"},
    {']', 1, "09191101"},
    {'/', 3, "0139"},
    {'_', 4, "0141"},
    {'%', 4, "0248 ~0608282606 ~2224444222"},
    {'!', 0, "0804 0202"},
    {'?', 3, "~070838351514 1212"},
    {'\'', 0, "0807"},
    {'"', 1, "0807 1817"},
    {'<', 3, "360432"},
    {'>', 3, "063402"},
    {'*', 4, "2723 0644 4604"},
    {'|', 0, "0901"},
    {'#', 4, "1218 3238 0646 0444"},
    {'&', 4, "~42071828160504022244"},
    {' ', 2, ""},
};
constexpr Glyph kUnknown = {'\0', 3, "0208383202"};
constexpr double kCapital = 6, kBaseLine = 2, kGap = 1.6;

const Glyph& glyph_of(char character) {
  const auto* found =
      std::find_if(std::begin(kGlyphs), std::end(kGlyphs), [&](const Glyph& g) { return g.character == character; });
  return found == std::end(kGlyphs) ? kUnknown : *found;
}

/// Whether a byte begins a character: the other bytes of UTF-8 have no width.
bool begins(char byte) { return (static_cast<unsigned char>(byte) & 0xC0) != 0x80; }

using Point = std::array<double, 2>;
using Stroke = std::vector<Point>;

/// Cuts the corners: in the limit the quadratic B-spline. The ends of an open stroke stay.
Stroke rounded(const Stroke& stroke) {
  const bool closed = stroke.front() == stroke.back();
  Stroke result;
  if (!closed) result.push_back(stroke.front());
  for (std::size_t i = 0; i + 1 < stroke.size(); ++i)
    for (const double share : {0.25, 0.75}) {
      if (!closed && ((i == 0 && share < 0.5) || (i + 2 == stroke.size() && share > 0.5))) continue;
      result.push_back({stroke[i][0] + share * (stroke[i + 1][0] - stroke[i][0]),
                        stroke[i][1] + share * (stroke[i + 1][1] - stroke[i][1])});
    }
  result.push_back(closed ? result.front() : stroke.back());
  return result;
}

std::vector<Stroke> strokes_of(const Glyph& glyph) {
  std::vector<Stroke> strokes;
  for (const char* at = glyph.strokes; *at != '\0';) {
    const bool round = *at == '~';
    if (round) ++at;
    Stroke stroke;
    for (; *at != '\0' && *at != ' '; at += 2)
      stroke.push_back({static_cast<double>(at[0] - '0'), static_cast<double>(at[1] - '0')});
    if (round)
      for (int i = 0; i < 3; ++i) stroke = rounded(stroke);
    strokes.push_back(std::move(stroke));
    if (*at == ' ') ++at;
  }
  return strokes;
}

double distance(const Point& p, const Point& a, const Point& b) {
  const double dx = b[0] - a[0], dy = b[1] - a[1], square = dx * dx + dy * dy;
  const double s = square > 0 ? std::clamp(((p[0] - a[0]) * dx + (p[1] - a[1]) * dy) / square, 0.0, 1.0) : 0.0;
  return std::hypot(p[0] - a[0] - s * dx, p[1] - a[1] - s * dy);
}

void draw_glyph(Image& image, const Glyph& glyph, double x, double y, double unit, Colour colour) {
  const std::vector<Stroke> strokes = strokes_of(glyph);
  const double radius = std::max(0.55, 0.36 * unit);
  const int left = static_cast<int>(std::floor(x - radius - 1));
  const int right = static_cast<int>(std::ceil(x + glyph.width * unit + radius + 1));
  const int top = static_cast<int>(std::floor(y - 7 * unit - radius - 1));
  const int bottom = static_cast<int>(std::ceil(y + kBaseLine * unit + radius + 1));
  for (int row = top; row < bottom; ++row)
    for (int column = left; column < right; ++column) {
      const Point p{(column + 0.5 - x) / unit, (y - row - 0.5) / unit + kBaseLine};
      double nearest = 1e9;
      for (const Stroke& stroke : strokes)
        for (std::size_t i = 0; i + 1 < stroke.size(); ++i)
          nearest = std::min(nearest, distance(p, stroke[i], stroke[i + 1]));
      image.blend(column, row, colour, std::clamp(radius + 0.5 - nearest * unit, 0.0, 1.0));
    }
}

}  // namespace

double text_width(std::string_view text, double height) {
  double width = 0;
  for (const char character : text)
    if (begins(character)) width += glyph_of(character).width + kGap;
  return std::max(0.0, width - kGap) * height / kCapital;
}

void draw_text(Image& image, std::string_view text, double x, double y, double height, Colour colour) {
  const double unit = height / kCapital;
  for (const char character : text) {
    if (!begins(character)) continue;
    const Glyph& glyph = glyph_of(character);
    draw_glyph(image, glyph, x, y, unit, colour);
    x += (glyph.width + kGap) * unit;
  }
}

std::string fit_text(std::string_view text, double height, double width) {
  if (text_width(text, height) <= width) return std::string(text);
  for (std::size_t n = text.size(); n > 0; --n)
    if (const std::string shorter = std::string(text.substr(0, n)) + "..."; text_width(shorter, height) <= width)
      return shorter;
  return {};
}

}  // namespace volccd
