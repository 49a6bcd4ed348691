-- driver.lua KERNEL SIZE: answers each line N on standard input by N passes over the grid, with the
-- sum of all results and the processor time in seconds. SIZE 0 stands for a kernel that is run as
-- it is.
local kernel, size = dofile(arg[1]), tonumber(arg[2])
io.stdout:setvbuf("line")

local function pass()
  local sum = 0.0
  for row = 0, size - 1 do
    local v = (row + 0.5) / size
    for column = 0, size - 1 do
      local r, g, b, kd, ks, n = kernel(0, (column + 0.5) / size, v)
      sum = sum + (r + g + b + kd + ks + n)
    end
  end
  return sum
end

for line in io.lines() do
  local sum, start = 0.0, os.clock()
  for _ = 1, tonumber(line) do
    if size == 0 then kernel() else sum = sum + pass() end
  end
  print(string.format("%.17g %.6f", sum, os.clock() - start))
end
