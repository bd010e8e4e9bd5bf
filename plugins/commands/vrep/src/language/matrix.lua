-- The globals `Matrix`, `Matrix3x3`, `Matrix4x4`, `Vector`, `Vector3`, `Vector4` and `Vector7`, which V-REP 4.1 to 4.10
-- provides to every script. Elements are stored row by row; indices start at 1; vectors are columns. The globals are
-- defined only for scripts that use one of these names.
local script = ...
local major, minor = (script.dialect or "0"):match("^(%d+)%.?(%d*)")
if (tonumber(major) or 0) * 100 + (tonumber(minor) or 0) < 401
    or not script.has("Matrix", "Matrix3x3", "Matrix4x4", "Vector", "Vector3", "Vector4", "Vector7")
then
    return {}
end
-- Local copies, because scripts can redefine these globals.
local type, getmetatable, setmetatable, ipairs, error, print = type, getmetatable, setmetatable, ipairs, error, print
local tostring, rawget, rawset, math, table, string = tostring, rawget, rawset, math, table, string

-- The class, which is also the metatable of matrices.
local Matrix = {}

local MOST = 250000

local function is_matrix(x) return type(x) == "table" and getmetatable(x) == Matrix end

local function new(rows, cols, data, offset)
    return setmetatable({ _rows = rows, _cols = cols, _data = data, _offset = offset or 0 }, Matrix)
end

-- Creates a matrix whose elements are f(i, j).
local function filled(rows, cols, f)
    if math.type(rows) ~= "integer" and math.tointeger(rows) then rows = math.tointeger(rows) end
    if math.type(cols) ~= "integer" and math.tointeger(cols) then cols = math.tointeger(cols) end
    if math.type(rows) ~= "integer" or math.type(cols) ~= "integer" or rows < 0 or cols < 0 or rows * cols > MOST then
        local size = tostring(rows) .. " x " .. tostring(cols)
        local limit = "with at most " .. MOST .. " elements in total"
        error("expected whole numbers of rows and columns " .. limit .. ", found " .. size, 3)
    end
    local data, n = {}, 0
    for i = 1, rows do
        for j = 1, cols do
            n = n + 1
            data[n] = f(i, j)
        end
    end
    return new(rows, cols, data)
end

-- Creates a matrix from a list of all elements, a function of row and column, or nil for zeros.
local function made(rows, cols, data)
    if type(data) == "function" then return filled(rows, cols, data) end
    if is_matrix(data) then data = data:data() end
    if data ~= nil and (type(data) ~= "table" or #data ~= rows * cols) then
        local found = type(data) == "table" and #data .. " elements" or "a " .. type(data)
        error(string.format("a %d x %d matrix requires %d elements, found %s", rows, cols, rows * cols, found), 3)
    end
    return filled(rows, cols, function(i, j) return data and data[(i - 1) * cols + j] or 0 end)
end

local function size(m) return string.format("%d x %d", m._rows, m._cols) end

local function at(m, i, j) return m._data[m._offset + (i - 1) * m._cols + j] end

function Matrix.__index(m, k)
    if type(k) ~= "number" then return Matrix[k] end
    local rows, cols = rawget(m, "_rows"), rawget(m, "_cols")
    if cols == 1 then return m:get(k, 1) end
    if rows == 1 then return m:get(1, k) end
    if k >= 1 and k <= rows then return m:rowref(k) end
end
function Matrix.__newindex(m, k, x)
    if type(k) ~= "number" then return rawset(m, k, x) end
    if m._cols == 1 then
        m:set(k, 1, x)
    elseif m._rows == 1 then
        m:set(1, k, x)
    else
        m:setrow(k, x)
    end
end
function Matrix.__len(m) return m._rows == 1 and m._cols or m._rows end

function Matrix:rows() return self._rows end
function Matrix:cols() return self._cols end
function Matrix:count() return self._rows * self._cols end
function Matrix:ismatrix(x)
    if x == nil then x = self end
    return is_matrix(x)
end
function Matrix:sameshape(rows, cols)
    if is_matrix(rows) then rows, cols = rows._rows, rows._cols end
    return self._rows == rows and self._cols == cols
end
function Matrix:offset(i, j)
    if i >= 1 and i <= self._rows and j >= 1 and j <= self._cols then
        return self._offset + (i - 1) * self._cols + j
    end
end
function Matrix:get(i, j)
    local k = self:offset(i, j)
    return k and self._data[k]
end
function Matrix:set(i, j, x)
    local k = self:offset(i, j)
    if k then self._data[k] = x end
    return self
end
function Matrix:data()
    local data = {}
    for k = 1, self._rows * self._cols do data[k] = self._data[self._offset + k] end
    return data
end
function Matrix:dataref() return self._data end
function Matrix:copy() return new(self._rows, self._cols, self:data()) end
function Matrix:row(i)
    if i >= 1 and i <= self._rows then return filled(1, self._cols, function(_, j) return at(self, i, j) end) end
end
function Matrix:col(j)
    if j >= 1 and j <= self._cols then return filled(self._rows, 1, function(i) return at(self, i, j) end) end
end
-- Returns a row that shares its elements with the matrix.
function Matrix:rowref(i)
    if i >= 1 and i <= self._rows then return new(1, self._cols, self._data, self._offset + (i - 1) * self._cols) end
end
local function elements(x) return is_matrix(x) and x:data() or x end
function Matrix:setrow(i, m)
    for j, x in ipairs(elements(m)) do self:set(i, j, x) end
    return self
end
function Matrix:setcol(j, m)
    for i, x in ipairs(elements(m)) do self:set(i, j, x) end
    return self
end
function Matrix:slice(row, col, last_row, last_col)
    return filled(last_row - row + 1, last_col - col + 1, function(i, j)
        return self:get(row + i - 1, col + j - 1) or 0
    end)
end
function Matrix:assign(row, col, m)
    for i = 1, m._rows do
        for j = 1, m._cols do self:set(row + i - 1, col + j - 1, at(m, i, j)) end
    end
    return self
end
function Matrix:droprow(row)
    return filled(self._rows - 1, self._cols, function(i, j) return at(self, i < row and i or i + 1, j) end)
end
function Matrix:dropcol(col)
    return filled(self._rows, self._cols - 1, function(i, j) return at(self, i, j < col and j or j + 1) end)
end
function Matrix:at(rows, cols)
    return filled(rows._rows, rows._cols, function(i, j) return self:get(at(rows, i, j), at(cols, i, j)) end)
end
function Matrix:t()
    return filled(self._cols, self._rows, function(i, j) return at(self, j, i) end)
end
function Matrix:horzcat(...)
    local out = self
    for _, m in ipairs { ... } do
        local left = out
        if m._rows ~= left._rows then
            error("horzcat requires equal numbers of rows, found " .. size(left) .. " and " .. size(m), 2)
        end
        out = filled(left._rows, left._cols + m._cols, function(i, j)
            return j <= left._cols and at(left, i, j) or at(m, i, j - left._cols)
        end)
    end
    return out
end
function Matrix:vertcat(...)
    local out = self
    for _, m in ipairs { ... } do
        local top = out
        if m._cols ~= top._cols then
            error("vertcat requires equal numbers of columns, found " .. size(top) .. " and " .. size(m), 2)
        end
        out = filled(top._rows + m._rows, top._cols, function(i, j)
            return i <= top._rows and at(top, i, j) or at(m, i - top._rows, j)
        end)
    end
    return out
end

function Matrix:applyfunc(f)
    return filled(self._rows, self._cols, function(i, j) return f(at(self, i, j)) end)
end
function Matrix:applyfuncidx(f)
    return filled(self._rows, self._cols, function(i, j) return f(i, j, at(self, i, j)) end)
end
-- Applies f(x, y) to the elements of two matrices of the same size, one of which may be a number.
local function pairwise(a, b, f, name)
    if type(a) == "number" then
        return b:applyfunc(function(y) return f(a, y) end)
    elseif type(b) == "number" then
        return a:applyfunc(function(x) return f(x, b) end)
    elseif not (is_matrix(a) and is_matrix(b)) then
        error(name .. " requires two matrices or a matrix and a number, found a " .. type(is_matrix(a) and b or a), 3)
    elseif a._rows ~= b._rows or a._cols ~= b._cols then
        error(string.format("%s requires matrices of equal size, found %s and %s", name, size(a), size(b)), 3)
    end
    return filled(a._rows, a._cols, function(i, j) return f(at(a, i, j), at(b, i, j)) end)
end
function Matrix:applyfunc2(m, f) return pairwise(self, m, f, "applyfunc2") end
function Matrix:binop(m, f) return pairwise(self, m, f, "binop") end

local function bit(x) return x and 1 or 0 end
for name, f in pairs {
    add = function(x, y) return x + y end,
    sub = function(x, y) return x - y end,
    times = function(x, y) return x * y end,
    div = function(x, y) return x / y end,
    idiv = function(x, y) return x // y end,
    mod = function(x, y) return x % y end,
    pow = function(x, y) return x ^ y end,
    fmod = function(x, y) return math.fmod(x, y) end,
    eq = function(x, y) return bit(x == y) end,
    ne = function(x, y) return bit(x ~= y) end,
    lt = function(x, y) return bit(x < y) end,
    le = function(x, y) return bit(x <= y) end,
    gt = function(x, y) return bit(x > y) end,
    ge = function(x, y) return bit(x >= y) end,
} do
    Matrix[name] = function(a, b) return pairwise(a, b, f, name) end
end
for _, name in ipairs { "abs", "acos", "asin", "atan", "ceil", "cos", "deg", "exp", "floor", "rad", "sin", "sqrt", "tan" } do
    local f = math[name]
    Matrix[name] = function(m) return m:applyfunc(function(x) return f(x) end) end
end
function Matrix:log(base)
    return self:applyfunc(function(x) return base and math.log(x, base) or math.log(x) end)
end
function Matrix:tointeger()
    return self:applyfunc(function(x) return math.tointeger(x) or math.tointeger(x < 0 and math.ceil(x) or math.floor(x)) end)
end
function Matrix:random(low, high)
    return self:applyfunc(function()
        if high then return math.random(low, high) end
        return low and math.random(low) or math.random()
    end)
end
function Matrix:where(cond, x, y)
    if y == nil then cond, x, y = self, cond, x end
    return filled(cond._rows, cond._cols, function(i, j)
        local c = at(cond, i, j)
        return at(c and c ~= 0 and x or y, i, j)
    end)
end
function Matrix:all(f)
    for _, x in ipairs(self:data()) do
        if not f(x) then return false end
    end
    return true
end
function Matrix:any(f)
    for _, x in ipairs(self:data()) do
        if f(x) then return true end
    end
    return false
end
function Matrix:nonzero()
    local out = {}
    for i = 1, self._rows do
        for j = 1, self._cols do
            if at(self, i, j) ~= 0 then out[#out + 1] = { i, j } end
        end
    end
    return out
end

-- Combines all elements, those of each column (1) or those of each row (2).
function Matrix:fold(dim, start, f)
    if dim == nil then
        local out = start
        for _, x in ipairs(self:data()) do out = f(out, x) end
        return out
    elseif dim == 1 then
        return filled(1, self._cols, function(_, j) return self:col(j):fold(nil, start, f) end)
    end
    return filled(self._rows, 1, function(i) return self:row(i):fold(nil, start, f) end)
end
function Matrix:sum(dim) return self:fold(dim, 0, function(a, b) return a + b end) end
function Matrix:prod(dim) return self:fold(dim, 1, function(a, b) return a * b end) end
function Matrix:mean(dim)
    return self:sum(dim) / (dim == nil and self:count() or dim == 1 and self._rows or self._cols)
end
local function extremum(better, start)
    return function(m, dim)
        if is_matrix(dim) then
            return pairwise(m, dim, function(x, y) return better(y, x) and y or x end, "comparison")
        elseif dim ~= nil then
            return m:fold(dim, start, function(x, y) return better(y, x) and y or x end)
        end
        local best, row, col
        for i = 1, m._rows do
            for j = 1, m._cols do
                local x = at(m, i, j)
                if best == nil or better(x, best) then best, row, col = x, i, j end
            end
        end
        return best, row, col
    end
end
Matrix.max = extremum(function(x, y) return x > y end, -math.huge)
Matrix.min = extremum(function(x, y) return x < y end, math.huge)

-- Multiplies matrices; a list of numbers is treated as a column.
function Matrix.mul(a, b)
    if type(a) == "number" or type(b) == "number" then return Matrix.times(a, b) end
    if is_matrix(a) and type(b) == "table" and not is_matrix(b) then b = made(#b, 1, b) end
    if not (is_matrix(a) and is_matrix(b)) then
        error("a matrix cannot be multiplied by a " .. type(is_matrix(a) and b or a), 2)
    end
    if a._cols ~= b._rows then
        local text = "a %s matrix cannot be multiplied by a %s matrix: the second must have %d rows"
        error(string.format(text, size(a), size(b), a._cols), 2)
    end
    return filled(a._rows, b._cols, function(i, j)
        local sum = 0
        for k = 1, a._cols do sum = sum + at(a, i, k) * at(b, k, j) end
        return sum
    end)
end
function Matrix:power(k)
    local out = Matrix:eye(self._rows)
    local base = k < 0 and self:inv() or self
    for _ = 1, math.abs(k) do out = out * base end
    return out
end
function Matrix:dot(m)
    local sum = 0
    local a, b = self:data(), elements(m)
    for i = 1, #a do sum = sum + a[i] * b[i] end
    return sum
end
function Matrix:cross(m)
    local a, b = self:data(), elements(m)
    return new(3, 1, { a[2] * b[3] - a[3] * b[2], a[3] * b[1] - a[1] * b[3], a[1] * b[2] - a[2] * b[1] })
end
function Matrix:norm() return math.sqrt(self:dot(self)) end
function Matrix:normalized() return self / self:norm() end
function Matrix:kron(m)
    return filled(self._rows * m._rows, self._cols * m._cols, function(i, j)
        return at(self, (i - 1) // m._rows + 1, (j - 1) // m._cols + 1)
            * at(m, (i - 1) % m._rows + 1, (j - 1) % m._cols + 1)
    end)
end
function Matrix:trace()
    local sum = 0
    for i = 1, math.min(self._rows, self._cols) do sum = sum + at(self, i, i) end
    return sum
end

-- Gaussian elimination below the pivots and, if `jordan` is set, also above them. Returns the result, and the
-- determinant of the left square part.
local function eliminated(m, jordan)
    local rows, cols, det = {}, m._cols, 1
    for i = 1, m._rows do rows[i] = m:row(i):data() end
    for k = 1, math.min(#rows, cols) do
        local pivot = k
        for i = k + 1, #rows do
            if math.abs(rows[i][k]) > math.abs(rows[pivot][k]) then pivot = i end
        end
        det = det * rows[pivot][k]
        if rows[pivot][k] ~= 0 then
            if pivot ~= k then
                rows[k], rows[pivot], det = rows[pivot], rows[k], -det
            end
            if jordan then
                local by = rows[k][k]
                for j = 1, cols do rows[k][j] = rows[k][j] / by end
            end
            for i = jordan and 1 or k + 1, #rows do
                if i ~= k then
                    local by = rows[i][k] / rows[k][k]
                    for j = 1, cols do rows[i][j] = rows[i][j] - by * rows[k][j] end
                end
            end
        end
    end
    return filled(m._rows, cols, function(i, j) return rows[i][j] end), det
end
local function square(m, what)
    if m._rows ~= m._cols then error("only a square matrix has " .. what .. ", found " .. size(m), 3) end
end
function Matrix:gauss(jordan) return (eliminated(self, jordan)) end
function Matrix:det()
    square(self, "a determinant")
    local _, det = eliminated(self, false)
    return det
end
function Matrix:inv()
    square(self, "an inverse")
    local n = self._rows
    local both, det = eliminated(self:horzcat(Matrix:eye(n)), true)
    if det == 0 then error("the matrix is singular, so it has no inverse", 2) end
    return both:slice(1, n + 1, n, 2 * n)
end

-- Converts points to and from homogeneous coordinates.
function Matrix:hom() return self._rows == 3 and self:vertcat(Matrix:ones(1, self._cols)) or self end
function Matrix:nonhom()
    return filled(3, self._cols, function(i, j) return at(self, i, j) / at(self, 4, j) end)
end
function Matrix:mult(v)
    v = is_matrix(v) and v or made(3, 1, v)
    return (self * v:hom()):nonhom()
end
function Matrix:axis(which)
    local j = ({ x = 1, y = 2, z = 3 })[which] or which
    return self:slice(1, j, 3, j)
end

function Matrix:eye(n) return filled(n, n, function(i, j) return i == j and 1 or 0 end) end
function Matrix:ones(rows, cols) return filled(rows, cols or rows, function() return 1 end) end
function Matrix:zeros(rows, cols) return filled(rows, cols or rows, function() return 0 end) end
-- Returns the diagonal matrix with the given elements, or without an argument, the diagonal of the matrix.
function Matrix:diag(e)
    if e == nil then
        return filled(math.min(self._rows, self._cols), 1, function(i) return at(self, i, i) end)
    end
    local values = elements(e)
    return filled(#values, #values, function(i, j) return i == j and values[i] or 0 end)
end
function Matrix:fromtable(t)
    return filled(#t, t[1] and #t[1] or 0, function(i, j) return t[i][j] end)
end
function Matrix:totable(format)
    if type(format) == "table" then return { dims = { self._rows, self._cols }, data = self:data() } end
    local out = {}
    for i = 1, self._rows do out[i] = self:row(i):data() end
    return out
end

function Matrix.__tostring(m)
    local data = m:data()
    for i, x in ipairs(data) do data[i] = tostring(x) end
    return string.format("Matrix(%d,%d,{%s})", m._rows, m._cols, table.concat(data, ","))
end
function Matrix:print(width)
    local texts, widest = {}, 0
    for i, x in ipairs(self:data()) do
        texts[i] = tostring(x)
        widest = math.max(widest, #texts[i])
    end
    width = width or widest
    for i = 1, self._rows do
        local row = {}
        for j = 1, self._cols do
            local text = texts[(i - 1) * self._cols + j]
            row[j] = string.rep(" ", width - #text) .. text
        end
        print(" " .. table.concat(row, " "))
    end
end

Matrix.__add, Matrix.__sub, Matrix.__mul, Matrix.__div = Matrix.add, Matrix.sub, Matrix.mul, Matrix.div
Matrix.__idiv, Matrix.__mod, Matrix.__pow = Matrix.idiv, Matrix.mod, Matrix.power
function Matrix.__unm(m) return m:applyfunc(function(x) return -x end) end
function Matrix.__eq(a, b)
    if a._rows ~= b._rows or a._cols ~= b._cols then return false end
    return pairwise(a, b, function(x, y) return bit(x ~= y) end, "comparison"):sum() == 0
end

setmetatable(Matrix, { __call = function(_, rows, cols, data)
    if type(rows) == "table" and cols == nil then
        return type(rows[1]) == "table" and Matrix:fromtable(rows) or made(#rows, 1, rows)
    end
    return made(rows, cols, data)
end })

-- Creates a class whose own functions are called with a colon, and which otherwise behaves like `Matrix`.
local function class(create)
    return setmetatable({}, { __index = Matrix, __call = function(_, ...) return create(...) end })
end
local Vector = class(function(len, data)
    if type(len) ~= "number" then len, data = is_matrix(len) and len:count() or #len, len end
    return made(len, 1, data)
end)
local function vector_of(n) return class(function(data) return made(n, 1, data) end) end
local Vector3, Vector4, Vector7 = vector_of(3), vector_of(4), vector_of(7)

-- Returns `num` values f(0) to f(1).
local function spaced(num, endpoint, f)
    num = num or 50
    local last = endpoint == false and num or num - 1
    return filled(num, 1, function(i) return f(last > 0 and (i - 1) / last or 0) end)
end
function Vector:linspace(start, stop, num, endpoint)
    return spaced(num, endpoint, function(s) return start + s * (stop - start) end)
end
function Vector:logspace(start, stop, num, endpoint, base)
    return spaced(num, endpoint, function(s) return (base or 10) ^ (start + s * (stop - start)) end)
end
function Vector:geomspace(start, stop, num, endpoint)
    return spaced(num, endpoint, function(s) return start * (stop / start) ^ s end)
end
function Vector:range(start, stop, step)
    if stop == nil then start, stop = 1, start end
    step = step or 1
    local data = {}
    for x = start, stop, step do data[#data + 1] = x end
    return made(#data, 1, data)
end
local function homogeneous(_, v)
    local data = elements(v)
    return made(4, 1, { data[1], data[2], data[3], data[4] or 1 })
end
Vector3.hom = function(self, v) return v == nil and Matrix.hom(self) or homogeneous(self, v) end
Vector4.hom = Vector3.hom
function Vector3:random() return filled(3, 1, function() return math.random() end) end
function Vector3:unitrandom()
    local z, turn = 2 * math.random() - 1, 2 * math.pi * math.random()
    local r = math.sqrt(1 - z * z)
    return made(3, 1, { r * math.cos(turn), r * math.sin(turn), z })
end

-- Returns numbers as a list, or as a column if the class `Matrix` is given.
local function answer(data, kind) return kind == Matrix and made(#data, 1, data) or data end

local Matrix3x3 = class(function(data) return made(3, 3, data) end)
function Matrix3x3:rotx(a)
    local c, s = math.cos(a), math.sin(a)
    return new(3, 3, { 1, 0, 0, 0, c, -s, 0, s, c })
end
function Matrix3x3:roty(a)
    local c, s = math.cos(a), math.sin(a)
    return new(3, 3, { c, 0, s, 0, 1, 0, -s, 0, c })
end
function Matrix3x3:rotz(a)
    local c, s = math.cos(a), math.sin(a)
    return new(3, 3, { c, -s, 0, s, c, 0, 0, 0, 1 })
end
function Matrix3x3:fromeuler(e)
    local a = elements(e)
    return Matrix3x3:rotx(a.x or a[1]) * Matrix3x3:roty(a.y or a[2]) * Matrix3x3:rotz(a.z or a[3])
end
function Matrix3x3:fromquaternion(q)
    local a = elements(q)
    local x, y, z, w = a.x or a[1], a.y or a[2], a.z or a[3], a.w or a[4]
    local n = math.sqrt(x * x + y * y + z * z + w * w)
    x, y, z, w = x / n, y / n, z / n, w / n
    return new(3, 3, {
        1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w),
        2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w),
        2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y),
    })
end
function Matrix3x3:fromaxisangle(axis, angle)
    local a, s = made(3, 1, elements(axis)):normalized(), math.sin(angle / 2)
    return Matrix3x3:fromquaternion { s * a[1], s * a[2], s * a[3], math.cos(angle / 2) }
end
function Matrix3x3:toeuler(m, kind)
    local beta = math.asin(math.max(-1, math.min(1, at(m, 1, 3))))
    if math.abs(at(m, 1, 3)) < 0.999995 then
        return answer({ math.atan(-at(m, 2, 3), at(m, 3, 3)), beta, math.atan(-at(m, 1, 2), at(m, 1, 1)) }, kind)
    end
    return answer({ 0, beta, math.atan(at(m, 2, 1), at(m, 2, 2)) }, kind)
end
function Matrix3x3:toquaternion(m, kind)
    local xx, yy, zz = at(m, 1, 1), at(m, 2, 2), at(m, 3, 3)
    -- The largest of the four numbers is computed first, because the others are divided by it.
    local squares = { 1 + xx - yy - zz, 1 - xx + yy - zz, 1 - xx - yy + zz, 1 + xx + yy + zz }
    local first = 4
    for i = 1, 3 do
        if squares[i] > squares[first] then first = i end
    end
    local q, r = {}, math.sqrt(squares[first])
    q[first] = r / 2
    local sums = { at(m, 2, 1) + at(m, 1, 2), at(m, 1, 3) + at(m, 3, 1), at(m, 3, 2) + at(m, 2, 3) }
    local turns = { at(m, 3, 2) - at(m, 2, 3), at(m, 1, 3) - at(m, 3, 1), at(m, 2, 1) - at(m, 1, 2) }
    local others = {
        { [2] = sums[1], [3] = sums[2], [4] = turns[1] },
        { [1] = sums[1], [3] = sums[3], [4] = turns[2] },
        { [1] = sums[2], [2] = sums[3], [4] = turns[3] },
        { [1] = turns[1], [2] = turns[2], [3] = turns[3] },
    }
    for i = 1, 4 do
        if i ~= first then q[i] = others[first][i] / (2 * r) end
    end
    return answer(q, kind)
end
function Matrix3x3:random() return Matrix3x3:fromaxisangle(Vector3:unitrandom(), 2 * math.pi * math.random()) end

local Matrix4x4 = class(function(data)
    local list = is_matrix(data) and data:data() or data
    if type(list) == "table" and #list == 12 then
        list = table.move({ 0, 0, 0, 1 }, 1, 4, 13, table.move(list, 1, 12, 1, {}))
    end
    return made(4, 4, list)
end)
function Matrix4x4:fromrt(r, t)
    local out, v = Matrix:eye(4), elements(t or { 0, 0, 0 })
    return out:assign(1, 1, r):setcol(4, { v.x or v[1], v.y or v[2], v.z or v[3], 1 })
end
function Matrix4x4:fromrotation(r) return Matrix4x4:fromrt(r) end
function Matrix4x4:fromposition(v) return Matrix4x4:fromrt(Matrix:eye(3), v) end
function Matrix4x4:fromeuler(e) return Matrix4x4:fromrt(Matrix3x3:fromeuler(e)) end
function Matrix4x4:fromquaternion(q) return Matrix4x4:fromrt(Matrix3x3:fromquaternion(q)) end
function Matrix4x4:frompose(p)
    local a = elements(p)
    return Matrix4x4:fromrt(Matrix3x3:fromquaternion { a[4], a[5], a[6], a[7] }, { a[1], a[2], a[3] })
end
function Matrix4x4:torotation(m) return m:slice(1, 1, 3, 3) end
function Matrix4x4:toposition(m, kind) return answer({ at(m, 1, 4), at(m, 2, 4), at(m, 3, 4) }, kind) end
function Matrix4x4:toeuler(m, kind) return Matrix3x3:toeuler(m, kind) end
function Matrix4x4:toquaternion(m, kind) return Matrix3x3:toquaternion(m, kind) end
function Matrix4x4:topose(m, kind)
    local p, q = Matrix4x4:toposition(m), Matrix3x3:toquaternion(m)
    return answer({ p[1], p[2], p[3], q[1], q[2], q[3], q[4] }, kind)
end
function Matrix4x4:inv(m)
    local turned = m:slice(1, 1, 3, 3):t()
    return Matrix4x4:fromrt(turned, -(turned * m:slice(1, 4, 3, 4)))
end
function Matrix4x4:random() return Matrix4x4:fromrt(Matrix3x3:random(), Vector3:random()) end

for name, value in pairs {
    Matrix = Matrix, Matrix3x3 = Matrix3x3, Matrix4x4 = Matrix4x4,
    Vector = Vector, Vector3 = Vector3, Vector4 = Vector4, Vector7 = Vector7,
} do
    if script.has(name) then _G[name] = value end
end
return {}
