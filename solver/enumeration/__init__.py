"""Every first-order solution at a point, with proof in interval arithmetic."""
