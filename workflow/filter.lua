-- Pandoc filter for the chapters: mathematics, equations, figures, references -> our Typst template.
--
-- Pandoc's Typst writer gets a number of TeX constructs wrong, some without a word. So a formula may
-- only use what stands in the lists below, each of which is set on the battery page of the tests;
-- anything else stops the build and shows the formula.

local function set(text)
  local members = {}
  for word in text:gmatch("%S+") do members[word] = true end
  return members
end

local commands = set [[
  left right langle rangle lfloor rfloor lceil rceil lbrace rbrace
  frac sqrt binom int sum prod infty partial nabla circ
  begin end text mathrm mathbf mathbb mathcal operatorname overline hat tilde bar vec underbrace
  sin cos tan cot sec csc arcsin arccos arctan sinh cosh tanh exp log ln min max lim sup inf arg
  le leq ge geq ne neq lt gt approx equiv sim propto ll gg to mapsto Rightarrow Leftrightarrow in notin
  subset forall mid colon cdot times pm mp ldots cdots dots quad qquad
  alpha beta gamma delta epsilon varepsilon zeta eta theta vartheta iota kappa lambda mu nu xi pi
  rho sigma tau phi varphi chi psi omega ell
  Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega
]]
local environments = set "aligned cases pmatrix bmatrix"
local closing = {["("] = ")", ["["] = "]", ["|"] = "|", ["\\langle"] = "\\rangle",
                 ["\\{"] = "\\}", ["\\lfloor"] = "\\rfloor", ["\\lceil"] = "\\rceil"}
local reference = {eq = true, fig = true, tbl = true, sec = true}

local function refuse(why, tex)
  io.stderr:write("\nThis formula uses " .. why .. ", which pandoc does not carry over to Typst:\n    "
    .. tex:gsub("%s+", " ") .. "\n")
  os.exit(3)
end

-- The delimiter that follows \left or \right, and where it ends.
local function delimiter(tex, from)
  local start = tex:match("^%s*()", from)
  local stop = select(2, tex:find("^\\%a+", start)) or select(2, tex:find("^\\.", start)) or start
  return tex:sub(start, stop), stop
end

local function check_pairs(tex)
  local open = {}
  for side, at in tex:gmatch("\\(%a+)()") do
    if side == "left" then
      local mark = delimiter(tex, at)
      if not closing[mark] then refuse("\\left" .. mark, tex) end
      open[#open + 1] = mark
    elseif side == "right" then
      local mark, start = delimiter(tex, at), table.remove(open)
      if not start or closing[start] ~= mark then
        refuse("the unmatched pair \\left" .. (start or "?") .. " \\right" .. mark, tex)
      end
    end
  end
  if #open > 0 then refuse("\\left" .. open[1] .. " without a \\right", tex) end
end

-- What is left when words in text and scaled bars are taken out.
local function bare(tex)
  return (tex:gsub("\\text%s*%b{}", " "):gsub("\\left%s*|", " "):gsub("\\right%s*|", " "))
end

local function check_bodies(tex)
  for name in tex:gmatch("\\begin(%b{})") do
    if not environments[name:sub(2, -2)] then refuse("the environment " .. name:sub(2, -2), tex) end
  end
  local outer = tex:gsub("\\begin{cases}.-\\end{cases}", ""):gsub("\\begin{%a-matrix}.-\\end{%a-matrix}", "")
  for body in outer:gmatch("\\begin{aligned}(.-)\\end{aligned}") do
    for row in (body:gsub("\\\\", "\1")):gmatch("[^\1]+") do
      if select(2, row:gsub("&", "")) > 1 then refuse("more than one & in a row of aligned", tex) end
    end
  end
end

local function check(tex)
  check_bodies(tex)
  if tex:find("\\left%s*\\{") and tex:find("{aligned}", 1, true) then
    refuse("\\left\\{ around aligned", tex)
  end
  check_pairs(tex)
  local rest = bare(tex)
  for name in rest:gmatch("\\(%a+)") do
    if not commands[name] then refuse("\\" .. name, tex) end
  end
  for sign in (rest:gsub("\\%a+", " "):gsub("\\\\", " ")):gmatch("\\(%A)") do
    if not sign:find("[,{}%%&]") then refuse("\\" .. sign, tex) end
  end
  if (rest:gsub("\\%a+", "")):find("|", 1, true) then refuse("a bar | without \\left and \\right", tex) end
end

-- A word in \mathrm is the name of a function, and is spaced as one.
local function named_functions(tex)
  return (tex:gsub("\\mathrm{(%a%a+)}", "\\operatorname{%1}"))
end

-- The power of a function stands at its name: in \cos \theta_o^{2} it would be the angle's.
local angular = set "cos sin tan cot"
local function powers_at_names(tex)
  return (tex:gsub("\\(%a+)%s*(\\theta_%a)%^(%b{})", function(name, angle, power)
    if angular[name] then return "\\" .. name .. "^" .. power .. " " .. angle .. " " end
  end))
end

local function roomy_cases(tex)
  return (tex:gsub("(\\begin{cases})(.-)(\\end{cases})", function(head, body, tail)
    return head .. body:gsub("&", "\\quad &") .. tail
  end))
end

-- TeX -> the inside of a Typst formula.
local function formula(tex)
  check(tex)
  local plain = pandoc.Pandoc{pandoc.Plain{pandoc.Math("InlineMath", roomy_cases(powers_at_names(named_functions(tex))))}}
  local written = pandoc.write(plain, "typst"):gsub("^%s+", ""):gsub("%s+$", "")
  local inside = written:match("^%$(.*)%$$")
  if not inside then refuse("something", tex) end
  -- \operatorname{erf} comes out as the text "erf"; \text as upright("erf").
  inside = inside:gsub('upright%("([^"]*)"%)', "upright(\1%1\1)")
  inside = inside:gsub('"([%a]+)"', 'op("%1")'):gsub("\1", '"')
  return (inside:gsub("^%s+", ""):gsub("%s+$", ""))
end

local function typst(text) return pandoc.RawInline("typst", text) end

local function quoted(text) return '"' .. text:gsub('[\\"]', "\\%0") .. '"' end

local function content(inlines)
  return "[" .. pandoc.write(pandoc.Pandoc{pandoc.Plain(inlines)}, "typst"):gsub("%s+$", "") .. "]"
end

function Math(math)
  if math.mathtype == "InlineMath" then return typst("$" .. formula(math.text) .. "$") end
  return typst("#math.equation(block: true, numbering: none, $ " .. formula(math.text) .. " $)")
end

-- $$ ... $$ {#eq:key}: a numbered equation. The template looks the key up in the ledger.
local function labelled_equation(para)
  local first = para.content[1]
  if not first or first.t ~= "Math" or first.mathtype ~= "DisplayMath" then return nil end
  local rest = pandoc.utils.stringify(pandoc.Inlines{table.unpack(para.content, 2)})
  local label = rest:match("^%s*{#(eq:[^}%s]+)}%s*$")
  if not label then return nil end
  return pandoc.RawBlock("typst", "$ " .. formula(first.text) .. " $ <" .. label .. ">")
end

local function bare_label(para)
  for _, inline in ipairs(para.content) do
    if inline.t == "Str" and inline.text:find("{#eq:", 1, true) then
      io.stderr:write("\nAn equation's label stands alone: write $$ ... $$ {#eq:name} in a paragraph of its own.\n")
      os.exit(3)
    end
  end
end

local function image_of(figure)
  local found
  figure:walk{Image = function(image) found = image end}
  return found
end

local places = {auto = "auto", top = "top", bottom = "bottom", here = "none"}

local function place_of(image)
  local place = image.attributes.place or "auto"
  if places[place] then return places[place] end
  io.stderr:write("\nA figure is placed auto, top, bottom or here, not " .. place .. ".\n")
  os.exit(3)
end

local function share(width) return (width or "100%"):gsub("%%$", "") .. "%" end

-- The caption's first words in bold are the figure's title.
local function title_and_rest(caption)
  if caption[1] and caption[1].t == "Strong" then
    return caption[1].content, pandoc.Inlines{table.unpack(caption, 2)}
  end
  return pandoc.Inlines{}, caption
end

function Figure(figure)
  local image = image_of(figure)
  if not image then return nil end
  local label = figure.identifier ~= "" and figure.identifier or image.identifier
  local caption = pandoc.utils.blocks_to_inlines(figure.caption.long)
  local title, rest = title_and_rest(caption)
  local call = string.format("#picture(%s, %s, %s, slides: (%s), width: %s, place: %s, alt: %s%s)",
    quoted("/" .. image.src), content(title), content(rest),
    (image.attributes.slides or ""):gsub("[%d]+$", "%0,"), share(image.attributes.width),
    place_of(image), quoted(pandoc.utils.stringify(#title > 0 and title or caption)),
    image.attributes.moving and ", moving: " .. quoted("/" .. image.attributes.moving) or "")
  return pandoc.RawBlock("typst", call .. (label ~= "" and " <" .. label .. ">" or ""))
end

-- [@eq:key] and its like are references; all other citations go to the bibliography.
function Cite(cite)
  local references, works = pandoc.Inlines{}, pandoc.List{}
  for _, one in ipairs(cite.citations) do
    if reference[one.id:match("^(%a+):") or ""] then
      if #references > 0 then references:extend{pandoc.Str(","), pandoc.Space()} end
      local how = one.mode == "SuppressAuthor" and "#refer-bare" or "#refer"
      references:insert(typst(how .. "(label(" .. quoted(one.id) .. "))"))
    else
      works:insert(one)
    end
  end
  if #references == 0 then return nil end
  if #works > 0 then
    io.stderr:write("\nA citation mixes references and works: [" .. cite.citations[1].id .. "; ...].\n")
    os.exit(3)
  end
  return references
end

function Div(div)
  if div.classes:includes("ledger") then return pandoc.RawBlock("typst", "#ledger-table()") end
  if div.classes:includes("note") then
    local body = pandoc.write(pandoc.Pandoc(div.content), "typst")
    return pandoc.RawBlock("typst", "#note[\n" .. body .. "\n]")
  end
end

-- A number stays on the line of its per cent sign, and of its error.
local function bound_numbers(inlines)
  for at = 2, #inlines - 1 do
    local before, gap, after = inlines[at - 1], inlines[at], inlines[at + 1]
    local spaced = gap.t == "Space" or gap.t == "SoftBreak"
    if spaced and (after.t == "Str" and after.text:match("^[%%±]") or before.t == "Str" and before.text == "±") then
      inlines[at] = pandoc.Str("\u{a0}")
    end
  end
  return inlines
end

-- Raw HTML and the like would vanish without a word.
local function refuse_raw(raw)
  if raw.format ~= "typst" then
    io.stderr:write("\nA chapter holds raw " .. raw.format .. ", which the report would lose: " .. raw.text .. "\n")
    os.exit(3)
  end
end

return {
  {RawInline = refuse_raw, RawBlock = refuse_raw},
  {Inlines = bound_numbers},
  {Para = function(para) return labelled_equation(para) end},
  {Para = bare_label},
  {Math = Math, Cite = Cite},
  {Figure = Figure, Div = Div},
}
