-- Counts down from two million as the GML program does: a function passed to itself.
local function count(n, self)
  if n == 0 then
    return
  end
  return self(n - 1, self)
end

return function()
  count(2000000, count)
end
