-- Matrices with operators. Elements are stored row by row; indices start at 1.
local Matrix, module = {}, {}
Matrix.__index = Matrix

local function is_matrix(x)
    return getmetatable(x) == Matrix
end

local function new(rows, columns, data)
    return setmetatable({ nrows = rows, ncols = columns, values = data }, Matrix)
end

-- Converts a list of rows to a matrix, or a list of numbers to a column; returns a matrix unchanged.
local function matrix_of(x)
    if is_matrix(x) then return x end
    if type(x) ~= 'table' then error('expected a matrix or a list of numbers, found ' .. type(x), 3) end
    return module(x)
end

local function each(a, b, name, f)
    if a.nrows ~= b.nrows or a.ncols ~= b.ncols then
        error(string.format('%s of a %d x %d and a %d x %d matrix: expected the same size', name,
            a.nrows, a.ncols, b.nrows, b.ncols), 3)
    end
    local data = {}
    for i = 1, #a.values do data[i] = f(a.values[i], b.values[i]) end
    return new(a.nrows, a.ncols, data)
end

local function scaled(m, by)
    local data = {}
    for i = 1, #m.values do data[i] = m.values[i] * by end
    return new(m.nrows, m.ncols, data)
end

function Matrix.__add(a, b)
    return each(matrix_of(a), matrix_of(b), 'the sum', function(x, y) return x + y end)
end
function Matrix.__sub(a, b)
    return each(matrix_of(a), matrix_of(b), 'the difference', function(x, y) return x - y end)
end
function Matrix.__unm(a) return scaled(a, -1) end
function Matrix.__div(a, b)
    if type(b) ~= 'number' then error('a matrix can only be divided by a number; to solve equations, use a:solve(b)', 2) end
    return scaled(a, 1 / b)
end
function Matrix.__mul(a, b)
    if type(a) == 'number' then return scaled(b, a) end
    if type(b) == 'number' then return scaled(a, b) end
    a, b = matrix_of(a), matrix_of(b)
    return new(a.nrows, b.ncols, linalg.multiply(a.values, a.nrows, b.values, b.nrows))
end
function Matrix.__eq(a, b)
    if a.nrows ~= b.nrows or a.ncols ~= b.ncols then return false end
    for i = 1, #a.values do if a.values[i] ~= b.values[i] then return false end end
    return true
end
function Matrix.__tostring(m)
    local rows = {}
    for i = 1, m.nrows do
        local row = {}
        for j = 1, m.ncols do row[j] = string.format('%.6g', m:get(i, j)) end
        rows[i] = '{' .. table.concat(row, ', ') .. '}'
    end
    return '{' .. table.concat(rows, ', ') .. '}'
end

function Matrix:rows() return self.nrows end
function Matrix:cols() return self.ncols end
function Matrix:data() return self.values end

local function index(m, i, j)
    local function fits(k, most) return math.type(k) == 'integer' and k >= 1 and k <= most end
    if not (fits(i, m.nrows) and fits(j, m.ncols)) then
        local place = string.format('(%s, %s)', tostring(i), tostring(j))
        error(string.format('there is no element %s in a %d x %d matrix', place, m.nrows, m.ncols), 3)
    end
    return (i - 1) * m.ncols + j
end

-- Returns the element in row i and column j. For a vector, i is the index of the element if j is omitted.
function Matrix:get(i, j)
    if j == nil then
        if self.nrows == 1 then i, j = 1, i else j = 1 end
    end
    return self.values[index(self, i, j)]
end
function Matrix:set(i, j, x)
    if x == nil then
        if self.nrows == 1 then i, j, x = 1, i, j else j, x = 1, j end
    end
    if type(x) ~= 'number' then error('an element of a matrix must be a number, found a ' .. type(x), 2) end
    self.values[index(self, i, j)] = x
    return self
end
function Matrix:row(i)
    local data = {}
    for j = 1, self.ncols do data[j] = self:get(i, j) end
    return new(1, self.ncols, data)
end
function Matrix:col(j)
    local data = {}
    for i = 1, self.nrows do data[i] = self:get(i, j) end
    return new(self.nrows, 1, data)
end
-- Copies another matrix into this one, with its first element in row i, column j.
function Matrix:assign(i, j, other)
    other = matrix_of(other)
    for r = 1, other.nrows do
        for c = 1, other.ncols do self:set(i + r - 1, j + c - 1, other:get(r, c)) end
    end
    return self
end

function Matrix:t()
    local data = {}
    for j = 1, self.ncols do
        for i = 1, self.nrows do data[#data + 1] = self.values[(i - 1) * self.ncols + j] end
    end
    return new(self.ncols, self.nrows, data)
end
function Matrix:copy() return scaled(self, 1) end
function Matrix:norm()
    local sum = 0
    for _, x in ipairs(self.values) do sum = sum + x * x end
    return math.sqrt(sum)
end
function Matrix:dot(other)
    local products = each(self, matrix_of(other), 'the dot product', function(x, y) return x * y end)
    local sum = 0
    for _, x in ipairs(products.values) do sum = sum + x end
    return sum
end
function Matrix:trace()
    if self.nrows ~= self.ncols then error('only a square matrix has a trace', 2) end
    local sum = 0
    for i = 1, self.nrows do sum = sum + self:get(i, i) end
    return sum
end

local function made(name)
    return function(m) return new(m.ncols, m.nrows, linalg[name](m.values, m.nrows)) end
end
Matrix.inv = made('inverse')
Matrix.pinv = made('pseudoInverse')
Matrix.exp = made('exponential')
Matrix.cholesky = made('cholesky')
function Matrix:det() return linalg.determinant(self.values, self.nrows) end
-- Returns x such that self * x = b; a list of numbers is treated as a column.
function Matrix:solve(b)
    b = matrix_of(b)
    return new(self.ncols, b.ncols, linalg.solve(self.values, self.nrows, b.values, b.nrows))
end
-- Returns the real and the imaginary parts of the eigenvalues, in ascending order of the real parts.
function Matrix:eigenvalues() return linalg.eigenvalues(self.values, self.nrows) end
-- Returns the eigenvalues of a symmetric matrix, in ascending order, and a matrix whose columns are the eigenvectors.
function Matrix:eigen()
    local values, vectors = linalg.symmetricEigen(self.values, self.nrows)
    return values, new(self.nrows, self.ncols, vectors)
end

local MOST = 250000

-- Raises an error unless a matrix of this size is allowed.
local function check_size(rows, columns)
    for _, n in ipairs{rows, columns} do
        if math.type(n) ~= 'integer' or n < 1 then
            error('a matrix size must be two positive integers, not ' .. tostring(rows) .. ', ' .. tostring(columns), 3)
        end
    end
    if rows > MOST or columns > MOST or rows * columns > MOST then
        error(string.format('a matrix can have at most %d elements, found %d x %d', MOST, rows, columns), 3)
    end
end

-- Copies the first `count` elements of a list; raises an error if one of them is not a number.
local function numbers_of(list, count)
    local data = {}
    for i = 1, count do
        if type(list[i]) ~= 'number' then
            error(string.format('element %d of a matrix is a %s: expected a number', i, type(list[i])), 3)
        end
        data[i] = list[i]
    end
    return data
end

local function filled(rows, columns, x)
    check_size(rows, columns)
    local data = {}
    for i = 1, rows * columns do data[i] = x end
    return new(rows, columns, data)
end
function module.zeros(rows, columns) return filled(rows, columns or rows, 0) end
function module.ones(rows, columns) return filled(rows, columns or rows, 1) end
function module.eye(n)
    local m = filled(n, n, 0)
    for i = 1, n do m:set(i, i, 1) end
    return m
end
function module.diag(values)
    local m = filled(#values, #values, 0)
    for i, x in ipairs(values) do m:set(i, i, x) end
    return m
end
function module.vector(values)
    check_size(#values, 1)
    return new(#values, 1, numbers_of(values, #values))
end
module.is = is_matrix

-- Constructors: Matrix{{1, 2}, {3, 4}}; Matrix{1, 2}, a column; Matrix(rows, columns, elements row by row).
return setmetatable(module, {
    __call = function(_, first, columns, data)
        if type(first) == 'number' then
            data = data or filled(first, columns, 0).values
            check_size(first, columns)
            if #data ~= first * columns then
                local size = string.format('%d x %d', first, columns)
                error(string.format('%d elements for a %s matrix: expected %d', #data, size, first * columns), 2)
            end
            return new(first, columns, numbers_of(data, #data))
        end
        if type(first) ~= 'table' or #first == 0 then error('expected a list of rows, such as {{1, 2}, {3, 4}}', 2) end
        if type(first[1]) ~= 'table' then return module.vector(first) end
        check_size(#first, #first[1])
        local numbers = {}
        for i, row in ipairs(first) do
            if type(row) ~= 'table' or #row ~= #first[1] then
                error(string.format('row %d must be a list of %d numbers, like row 1', i, #first[1]), 2)
            end
            for _, x in ipairs(numbers_of(row, #row)) do numbers[#numbers + 1] = x end
        end
        return new(#first, #first[1], numbers)
    end,
})
